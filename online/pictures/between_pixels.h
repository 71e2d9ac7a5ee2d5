// A picture between its pixels, one place after the other: for those who ask for few places. Whole pictures
// are read along a flow by warp.h. Reentrant.
#pragma once

#include <algorithm>

#include "hal/core/image.h"

namespace hdrcam {

struct Offset {
  float x = 0, y = 0;  // pixels
};
inline Offset operator*(float by, Offset offset) { return {by * offset.x, by * offset.y}; }
inline Offset offset_at(const Image<float>& vectors, int x, int y) {
  return {vectors.at(0, y, x), vectors.at(1, y, x)};
}

// A place in pictures of one size, x and y counted from the middle of the first pixel; outside, the nearest
// place inside. Where it is not a number: the first pixel.
class BetweenPixels {
 public:
  // Where a pixel is when it is moved.
  BetweenPixels(int rows, int cols, int x, int y, Offset by) {
    const float to_x = static_cast<float>(x) + by.x, to_y = static_cast<float>(y) + by.y;
    const float inside_x = std::min(std::max(0.f, to_x), static_cast<float>(cols - 1));
    const float inside_y = std::min(std::max(0.f, to_y), static_cast<float>(rows - 1));
    left_ = static_cast<int>(inside_x), above_ = static_cast<int>(inside_y);
    right_ = std::min(left_ + 1, cols - 1), below_ = std::min(above_ + 1, rows - 1);
    fx_ = inside_x - static_cast<float>(left_), fy_ = inside_y - static_cast<float>(above_);
  }

  // Bilinear.
  float of(const Image<float>& picture, int channel) const {
    const float *above = picture.row(channel, above_), *below = picture.row(channel, below_);
    const float upper = above[left_] + fx_ * (above[right_] - above[left_]);
    const float lower = below[left_] + fx_ * (below[right_] - below[left_]);
    return upper + fy_ * (lower - upper);
  }
  Offset vector_of(const Image<float>& vectors) const { return {of(vectors, 0), of(vectors, 1)}; }

 private:
  int left_, right_, above_, below_;
  float fx_, fy_;
};

}  // namespace hdrcam
