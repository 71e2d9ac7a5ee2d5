// An upright edge between dark and bright, and what a blur along x leaves of it. Reentrant.
#pragma once

#include <algorithm>

#include "hal/core/image.h"

namespace hdrcam::test {

struct MovingEdge {
  static constexpr int kRows = 16, kCols = 64, kEdge = 32;
  static constexpr float kDark = 0.1f, kBright = 0.6f;

  static float sharp(int x) { return x < kEdge ? kDark : kBright; }
  // After a blur of so many pixels: a ramp around the edge.
  static float ramp(int x, float length_px) {
    const float along = (static_cast<float>(x - kEdge) + 0.5f) / length_px + 0.5f;
    return kDark + (kBright - kDark) * std::clamp(along, 0.f, 1.f);
  }
  static Image<float> picture() {  // [rgb, rows, cols] radiance
    Image<float> picture(3, kRows, kCols);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) picture.at(c, y, x) = sharp(x);
    return picture;
  }
  static Image<float> to_the_right(float px) {  // [dx dy, rows, cols]
    Image<float> flow(2, kRows, kCols);
    std::fill_n(flow.plane(0), flow.plane_size(), px);
    return flow;
  }
};

}  // namespace hdrcam::test
