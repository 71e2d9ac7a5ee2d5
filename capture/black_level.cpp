#include "capture/black_level.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace hdrcam {
namespace {

constexpr float kMaxBlack = 24;     // codes: more is no black level but a bright scene
constexpr float kTrustedGap = 3;    // codes between darkest code and fixed point that still mean the same

std::vector<float> sorted_codes(const ExposedFrame& frame, int channel) {
  const float* plane = frame.codes.plane(channel);
  std::vector<float> codes(plane, plane + frame.codes.plane_size());
  std::sort(codes.begin(), codes.end());
  return codes;
}

// Fixed point of the line through the dark quantiles of the short against those of the long exposure; `fallback` where
// they do not span enough codes to define a line.
float fixed_point(const std::vector<float>& dark, const std::vector<float>& light, float fallback) {
  constexpr int kQuantiles = 400;
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t q = 1; q < kQuantiles; ++q) {
    const double x = static_cast<double>(light[light.size() * q / kQuantiles]);
    const double y = static_cast<double>(dark[dark.size() * q / kQuantiles]);
    if (x > 90 || y > 60) break;
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double spread = n * sxx - sx * sx;
  if (n < 8 || spread < n * n * 9) return fallback;  // a standard deviation of 3 codes
  const double slope = (n * sxy - sx * sy) / spread;
  if (slope < 0 || slope > 0.9) return fallback;
  return static_cast<float>((sy - slope * sx) / n / (1 - slope));
}

}  // namespace

BlackLevel estimate_black_level(std::span<const ExposedFrame> frames) {
  BlackLevel black{};
  if (frames.size() < 2) return black;
  const auto by_exposure = [](const ExposedFrame& a, const ExposedFrame& b) { return a.exposure < b.exposure; };
  const auto [shortest, longest] = std::minmax_element(frames.begin(), frames.end(), by_exposure);
  if (longest->exposure < 1.5f * shortest->exposure) return black;
  for (int c = 0; c < 3; ++c) {
    const auto dark = sorted_codes(*shortest, c), light = sorted_codes(*longest, c);
    const float darkest = dark[dark.size() / 2000];
    const float fixed = std::max(0.f, fixed_point(dark, light, darkest));
    const float level = darkest - fixed <= kTrustedGap ? darkest : fixed;
    black[static_cast<std::size_t>(c)] = std::clamp(level, 0.f, kMaxBlack);
  }
  return black;
}

}  // namespace hdrcam
