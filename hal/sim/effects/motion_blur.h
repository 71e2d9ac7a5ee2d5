// Motion blur: radiance is averaged over the exposure, with as many instants as the motion is long in the picture, and
// one where it is shorter than half a pixel. Value type, reentrant.
#pragma once

#include <algorithm>
#include <cmath>

namespace hdrcam {

struct MotionBlurSettings {
  int most_samples = 24;  // of one pixel, 1..64: longer motions are sampled more coarsely than a pixel
};

class MotionBlur {
 public:
  explicit MotionBlur(MotionBlurSettings settings) : most_(std::clamp(settings.most_samples, 1, 64)) {}

  static constexpr float kSharp_px = 0.5f;  // motions up to here are left alone

  // blur_px: the way of a point through the picture during the exposure.
  int samples(float blur_px) const {
    if (blur_px <= kSharp_px) return 1;
    return std::clamp(static_cast<int>(std::ceil(1.5f * blur_px)) + 1, 3, most_);
  }
  // The k-th of n instants, as a fraction of the exposure.
  static double fraction(int k, int n) { return (k + 0.5) / n; }

 private:
  int most_;
};

}  // namespace hdrcam
