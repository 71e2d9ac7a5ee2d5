// Radial lens distortion: the ray r is seen at r (1 + k1 |r|^2 + k2 |r|^4) (Brown 1971, radial terms). Value
// type, reentrant.
#pragma once

#include "hal/sim/geometry.h"

namespace hdrcam {

struct DistortionSettings {
  float k1 = -0.12f;  // < 0: barrel, as in wide lenses
  float k2 = 0.02f;
};

class Distortion {
 public:
  explicit Distortion(DistortionSettings settings) : k1_(settings.k1), k2_(settings.k2) {}

  Vec2 distorted(Vec2 ray) const {
    const float r2 = ray.x * ray.x + ray.y * ray.y, factor = 1 + r2 * (k1_ + r2 * k2_);
    return {ray.x * factor, ray.y * factor};
  }

  // The inverse: three terms of its series, then two of Newton's steps, 1e-6 up to a seen ray of 1.25 (the
  // corner of a 4:3 picture that is 90 degrees wide); by halves beyond, where the series does not converge.
  Vec2 undistorted(Vec2 seen) const {
    const float seen2 = seen.x * seen.x + seen.y * seen.y;
    if (seen2 > kSeriesTo * kSeriesTo) return far_undistorted(seen, seen2);
    float factor = 1 - seen2 * (k1_ + seen2 * (k2_ - 3 * k1_ * k1_));
    for (int step = 0; step < 2; ++step) {
      const float r2 = seen2 * factor * factor;
      factor -= (factor * (1 + r2 * (k1_ + r2 * k2_)) - 1) / (1 + r2 * (3 * k1_ + 5 * r2 * k2_));
    }
    return {seen.x * factor, seen.y * factor};
  }

 private:
  static constexpr float kSeriesTo = 1.26f;

  Vec2 far_undistorted(Vec2 seen, float seen2) const {
    float least = 0, most = 2;  // of the factor
    for (int step = 0; step < 24; ++step) {
      const float factor = (least + most) / 2, r2 = seen2 * factor * factor;
      (factor * (1 + r2 * (k1_ + r2 * k2_)) < 1 ? least : most) = factor;
    }
    return {seen.x * least, seen.y * least};
  }

  float k1_, k2_;
};

}  // namespace hdrcam
