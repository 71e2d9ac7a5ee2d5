// A picture between its pixels, one place after the other: for those who ask for few places. Whole pictures
// are read along a flow by warp.h. priors/depth/grid_sample.h, the point tracks' sample_flow and the field's
// fetch_base weigh the same pixels by other formulas, with other last bits, so they stay apart; and so do the
// weights of Catmull and Rom in the kernels, texture_error.cpp and render/views/cubic_between_pixels.h.
// Reentrant.
#pragma once

#include <algorithm>
#include <cmath>

#include "hal/core/image.h"

namespace hdrcam {

struct Offset {
  float x = 0, y = 0;  // pixels
};
inline Offset operator*(float by, Offset offset) { return {by * offset.x, by * offset.y}; }
inline float length_of(Offset offset) { return std::hypot(offset.x, offset.y); }
inline Offset offset_at(const Image<float>& vectors, int x, int y) {
  return {vectors.at(0, y, x), vectors.at(1, y, x)};
}

// Where a place along a line of pixels is: between these two.
struct AxisTap {
  int low, high;
  float share;  // of `high`
};
// place: counted from the middle of the first of `size` pixels; outside, the nearest place inside. Where it
// is not a number: the first pixel.
inline AxisTap tap_at(float place, int size) {
  const float inside = std::min(std::max(0.f, place), static_cast<float>(size - 1));
  const int low = static_cast<int>(inside);
  return {low, std::min(low + 1, size - 1), inside - static_cast<float>(low)};
}

// A place in pictures of one size.
class BetweenPixels {
 public:
  BetweenPixels(AxisTap y, AxisTap x) : y_(y), x_(x) {}
  // Where a pixel is when it is moved.
  BetweenPixels(int rows, int cols, int x, int y, Offset by)
      : BetweenPixels(tap_at(static_cast<float>(y) + by.y, rows),
                      tap_at(static_cast<float>(x) + by.x, cols)) {}

  // Bilinear.
  float of(const Image<float>& picture, int channel) const {
    const float *above = picture.row(channel, y_.low), *below = picture.row(channel, y_.high);
    const float upper = above[x_.low] + x_.share * (above[x_.high] - above[x_.low]);
    const float lower = below[x_.low] + x_.share * (below[x_.high] - below[x_.low]);
    return upper + y_.share * (lower - upper);
  }
  Offset vector_of(const Image<float>& vectors) const { return {of(vectors, 0), of(vectors, 1)}; }

 private:
  AxisTap y_, x_;
};

}  // namespace hdrcam
