// Motion blur: radiance is averaged over the exposure, with at least four instants and one per pixel of
// motion, and a single one where the motion is shorter than half a pixel. Value type, reentrant.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>

namespace hdrcam {

struct MotionBlurSettings {
  unsigned most_samples = 32;  // of one pixel, a power of two up to 32; longer motion is sampled coarsely
};

class MotionBlur {
 public:
  explicit MotionBlur(MotionBlurSettings settings)
      : most_(std::bit_floor(std::clamp(settings.most_samples, 1u, 32u))) {}

  static constexpr float kSharp_px = 0.5f;  // shorter motions are not sampled

  // blur_px: the motion of a point in the picture during the exposure. Returns a power of two.
  int samples(float blur_px) const {
    if (blur_px <= kSharp_px) return 1;
    constexpr float kFew = 4;  // fewer places in the pixel would follow the motion
    const float wanted = std::min(std::max(kFew, std::ceil(blur_px)), static_cast<float>(most_));
    return static_cast<int>(std::bit_ceil(static_cast<unsigned>(wanted)));
  }
  // The k-th of n instants, as a fraction of the exposure.
  static double fraction(int k, int n) { return (k + 0.5) / n; }

 private:
  unsigned most_;
};

}  // namespace hdrcam
