#include "render/time_code.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "hal/core/check.h"

namespace hdrcam {
namespace {

// 24, 30 or 60 of a camera of so many Hz / 1.001: what one of its seconds counts, which lasts 1.001 s
// (non-drop). None of any other rate.
std::optional<double> slowed_rate_hz(double framerate_hz) {
  constexpr double kSlower = 1.001, kSlowest_hz = 24;
  constexpr double kNearly = 1e-4;  // the interval may be of whole microseconds, up to 120 Hz
  const auto is_nearly = [&](double hz) { return std::abs(framerate_hz - hz) < kNearly * framerate_hz; };
  const double rate_hz = std::round(kSlower * framerate_hz);
  const bool slowed = !is_nearly(std::round(framerate_hz)) && is_nearly(rate_hz / kSlower);
  return slowed && rate_hz >= kSlowest_hz ? std::optional(rate_hz) : std::nullopt;
}

}  // namespace

TimeCode time_code(Duration since_start, double framerate_hz) {
  HDRCAM_CHECK(since_start.count() >= 0);
  HDRCAM_CHECK_GT(framerate_hz, 0.0);
  constexpr int kFrames = 30;  // the largest count; faster cameras count pairs, triples.. of frames (ST 12-1)
  // An interval of 33,333 us, or of whole nanoseconds, is 30 Hz and a little more.
  constexpr double kNearly = 0.99;
  const std::optional<double> slowed_hz = slowed_rate_hz(framerate_hz);
  const double rate_hz = slowed_hz.value_or(framerate_hz);
  const double counts_per_s = rate_hz / std::ceil(kNearly * rate_hz / kFrames);
  // Times tremble, and those of Matroska are whole milliseconds: frame n at about n / 30 s is frame n.
  const Duration counted = slowed_hz ? since_start - since_start / 1001 : since_start;
  const Duration time = counted + from_seconds(0.5 / std::max<double>(rate_hz, kFrames));
  const auto second = time.count() / 1'000'000'000;
  const double fraction = static_cast<double>(time.count() % 1'000'000'000) * 1e-9;
  const int frame = std::min(static_cast<int>(fraction * counts_per_s), kFrames - 1);
  return {static_cast<int>(second / 3600 % 24), static_cast<int>(second / 60 % 60),
          static_cast<int>(second % 60), frame};
}

}  // namespace hdrcam
