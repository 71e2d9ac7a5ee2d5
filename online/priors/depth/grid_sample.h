// A position between four grid points, and the values of those four. Value types, reentrant.
#pragma once

#include <algorithm>
#include <optional>

#include "hal/core/image.h"

namespace hdrcam {

struct GridPlace {
  int x0 = 0, y0 = 0;    // the point to the upper left
  float fx = 0, fy = 0;  // 0..1 from there to the next

  float x() const { return static_cast<float>(x0) + fx; }
  float y() const { return static_cast<float>(y0) + fy; }
  int nearest_x() const { return x0 + (fx > 0.5f); }
  int nearest_y() const { return y0 + (fy > 0.5f); }
};

// x, y: grid points, of a grid of at least 2x2. Nothing: outside, or not a number.
inline std::optional<GridPlace> locate(float x, float y, int rows, int cols) {
  if (!(x >= 0 && y >= 0 && x <= static_cast<float>(cols - 1) && y <= static_cast<float>(rows - 1)))
    return std::nullopt;
  GridPlace place;
  place.x0 = std::min(static_cast<int>(x), cols - 2);
  place.y0 = std::min(static_cast<int>(y), rows - 2);
  place.fx = x - static_cast<float>(place.x0);
  place.fy = y - static_cast<float>(place.y0);
  return place;
}

struct Corners {
  float a, b, c, d;  // upper left, upper right, lower left, lower right

  float mix(const GridPlace& p) const {
    return (a + (b - a) * p.fx) * (1 - p.fy) + (c + (d - c) * p.fx) * p.fy;
  }
  float least() const { return std::min(std::min(a, b), std::min(c, d)); }
  float spread() const { return std::max(std::max(a, b), std::max(c, d)) - least(); }
};

inline Corners corners(const Image<float>& image, int channel, const GridPlace& p) {
  const float* upper = image.row(channel, p.y0) + p.x0;
  const float* lower = image.row(channel, p.y0 + 1) + p.x0;
  return {upper[0], upper[1], lower[0], lower[1]};
}

}  // namespace hdrcam
