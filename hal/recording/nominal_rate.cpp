#include "hal/recording/nominal_rate.h"

extern "C" {
#include <libavutil/rational.h>
}

#include <cmath>

namespace hdrcam {
namespace {

// 24, 30, 48, 60, 120 ..: rates of which television has one a thousandth slower.
bool has_slower(double whole_hz) {
  return whole_hz >= 24 && (std::fmod(whole_hz, 24) == 0 || std::fmod(whole_hz, 30) == 0);
}

}  // namespace

NominalRate nominal_rate(double hz) {
  constexpr double kNearly_hz = 0.002, kMost_hz = 1e6, kSlower = 1.001;
  const auto is_nearly = [&](double nominal_hz) { return std::abs(hz - nominal_hz) < kNearly_hz; };
  const double whole_hz = std::round(hz), slowed_hz = std::round(kSlower * hz);
  // Of whole nanoseconds, the interval of 30 Hz would be 100000021 / 3333334.
  if (whole_hz >= 1 && whole_hz <= kMost_hz && is_nearly(whole_hz)) return {static_cast<int>(whole_hz), 1};
  if (slowed_hz <= kMost_hz && has_slower(slowed_hz) && is_nearly(slowed_hz / kSlower))
    return {1000 * static_cast<int>(slowed_hz), 1001};
  const AVRational fraction = av_d2q(hz, 1 << 20);
  return {fraction.num, fraction.den};
}

}  // namespace hdrcam
