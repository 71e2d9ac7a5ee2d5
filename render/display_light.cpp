#include "render/display_light.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr double kPqPeak_nits = 10000;
constexpr double kM1 = 2610.0 / 16384, kM2 = 2523.0 / 4096 * 128;  // SMPTE ST 2084, eq. 4.1
constexpr double kC1 = 3424.0 / 4096, kC2 = 2413.0 / 4096 * 32, kC3 = 2392.0 / 4096 * 32;

// Rec. ITU-R BT.2087-0: linear BT.709 to linear BT.2020.
constexpr float kBt2020FromBt709[3][3] = {
    {0.6274f, 0.3293f, 0.0433f}, {0.0691f, 0.9195f, 0.0114f}, {0.0164f, 0.0880f, 0.8956f}};

}  // namespace

double pq_signal(double nits) {
  const double power = std::pow(std::clamp(nits / kPqPeak_nits, 0.0, 1.0), kM1);
  return std::pow((kC1 + kC2 * power) / (1 + kC3 * power), kM2);
}

double pq_nits(double signal) {
  const double power = std::pow(std::clamp(signal, 0.0, 1.0), 1 / kM2);
  return kPqPeak_nits * std::pow(std::max(power - kC1, 0.0) / (kC2 - kC3 * power), 1 / kM1);
}

HighlightShoulder::HighlightShoulder(double source_peak_nits, double peak_nits)
    : source_signal_(pq_signal(std::max(source_peak_nits, peak_nits))),
      peak_(pq_signal(peak_nits) / source_signal_),
      peak_nits_(peak_nits),
      knee_(1.5 * peak_ - 0.5),
      knee_nits_(pq_nits(std::max(knee_, 0.0) * source_signal_)) {}

// BT.2390-8, section 5.4.1, steps 1 to 3.
double HighlightShoulder::shown(double nits) const {
  if (nits <= knee_nits_) return nits;
  if (peak_ >= 1) return std::min(nits, peak_nits_);
  const double signal = std::min(pq_signal(nits) / source_signal_, 1.0);
  const double t = (signal - knee_) / (1 - knee_);
  const double t2 = t * t, t3 = t2 * t;
  const double bent =
      (2 * t3 - 3 * t2 + 1) * knee_ + (t3 - 2 * t2 + t) * (1 - knee_) + (3 * t2 - 2 * t3) * peak_;
  return std::min(pq_nits(bent * source_signal_), peak_nits_);
}

DisplayLight::DisplayLight(double white_nits, double peak_nits, double brightest)
    : white_nits_(white_nits), shoulder_(brightest * white_nits, peak_nits) {}

PictureLight DisplayLight::show(const Image<float>& radiance, Image<float>& light) const {
  HDRCAM_CHECK(light.rows() >= radiance.rows() && light.cols() >= radiance.cols() && light.channels() == 3);
  constexpr float kBrightest = 1e30f;  // what is above it would be infinite in cd/m2, and then no number
  const auto scale = static_cast<float>(white_nits_);
  const auto knee = static_cast<float>(shoulder_.knee_nits());
  float largest = 0;
  double sum = 0;
  for (int y = 0; y < radiance.rows(); ++y) {
    const float *r = radiance.row(0, y), *g = radiance.row(1, y), *b = radiance.row(2, y);
    float* const out[3] = {light.row(0, y), light.row(1, y), light.row(2, y)};
    for (int x = 0; x < radiance.cols(); ++x) {
      const float rgb[3] = {std::min(r[x], kBrightest), std::min(g[x], kBrightest),
                            std::min(b[x], kBrightest)};
      float nits[3];
      for (int c = 0; c < 3; ++c) {
        const float(&m)[3] = kBt2020FromBt709[c];
        nits[c] = scale * (m[0] * rgb[0] + m[1] * rgb[1] + m[2] * rgb[2]);
      }
      float most = std::max({nits[0], nits[1], nits[2]});
      if (most > knee) {  // all three by one factor: the hue stays
        const auto shown = static_cast<float>(shoulder_.shown(most));
        for (float& value : nits) value *= shown / most;
        most = shown;
      }
      for (int c = 0; c < 3; ++c) out[c][x] = nits[c];
      largest = std::max(largest, most);
      sum += static_cast<double>(most);
    }
  }
  const auto pixels = static_cast<double>(std::max<std::size_t>(radiance.plane_size(), 1));
  return {static_cast<double>(largest), sum / pixels};
}

}  // namespace hdrcam
