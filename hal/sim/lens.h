// Maps pixels to rays: pinhole intrinsics and, where the scene needs it, radial distortion. Value type,
// reentrant.
#pragma once

#include <numbers>
#include <optional>

#include "hal/core/frame.h"
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

  Lens(const Intrinsics& of, std::optional<Distortion> bent)
      : intrinsics(of),
        distortion(bent),
        focal_px_{static_cast<float>(of.fx_px), static_cast<float>(of.fy_px)},
        per_focal_px_{1 / focal_px_.x, 1 / focal_px_.y},
        centre_px_{static_cast<float>(of.cx_px), static_cast<float>(of.cy_px)} {}

  Vec2 ray_of(float x_px, float y_px) const {
    const Vec2 seen{(x_px - centre_px_.x) * per_focal_px_.x, (y_px - centre_px_.y) * per_focal_px_.y};
    return distortion ? distortion->undistorted(seen) : seen;
  }
  Vec2 pixel_of(Vec2 ray) const {
    const Vec2 seen = distortion ? distortion->distorted(ray) : ray;
    return {seen.x * focal_px_.x + centre_px_.x, seen.y * focal_px_.y + centre_px_.y};
  }

 private:
  Vec2 focal_px_, per_focal_px_, centre_px_;  // of the intrinsics, in single precision
};

}  // namespace hdrcam
