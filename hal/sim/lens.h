// Where pixels look: pinhole intrinsics and, when the scene calls for it, radial distortion. Value type,
// reentrant.
#pragma once

#include <numbers>
#include <optional>

#include "hal/recording/recording.h"
#include "hal/sim/effects/distortion.h"
#include "hal/sim/geometry.h"

namespace hdrcam {

// A lens of this horizontal field of view over a picture of width x height pixels, its axis in the middle.
inline Intrinsics centred_intrinsics(int width, int height, double view_rad) {
  const double focal = width / 2.0 / std::tan(view_rad / 2);
  return {focal, focal, width / 2.0, height / 2.0};
}

struct Lens {
  Intrinsics intrinsics;
  std::optional<Distortion> distortion;

  Vec2 ray_of(float x_px, float y_px) const {
    const Vec2 seen{(x_px - static_cast<float>(intrinsics.cx_px)) / static_cast<float>(intrinsics.fx_px),
                    (y_px - static_cast<float>(intrinsics.cy_px)) / static_cast<float>(intrinsics.fy_px)};
    return distortion ? distortion->undistorted(seen) : seen;
  }
  Vec2 pixel_of(Vec2 ray) const {
    const Vec2 seen = distortion ? distortion->distorted(ray) : ray;
    return {seen.x * static_cast<float>(intrinsics.fx_px) + static_cast<float>(intrinsics.cx_px),
            seen.y * static_cast<float>(intrinsics.fy_px) + static_cast<float>(intrinsics.cy_px)};
  }
};

}  // namespace hdrcam
