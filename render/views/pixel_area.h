// The mean of a picture over a square of its pixels, each as far as it is covered: what a pixel of a reduced
// picture shows. Borrows nothing. Reentrant.
#pragma once

#include <algorithm>
#include <cmath>

#include "hal/core/image.h"

namespace hdrcam {

class PixelArea {
 public:
  // x, y: its middle, pixel centres at +0.5, in a picture of this size or on its border; side: more than 0.
  // What of it lies outside does not count.
  PixelArea(float x, float y, float side, int rows, int cols) : y_(y, side, rows), x_(x, side, cols) {}

  float mean(const Image<float>& picture, int channel) const {
    float sum = 0;
    for (int row = y_.first; row <= y_.last; ++row) {
      const float* pixels = picture.row(channel, row);
      float line = 0;
      for (int col = x_.first; col <= x_.last; ++col) line += x_.covered(col) * pixels[col];
      sum += y_.covered(row) * line;
    }
    return sum / (y_.length() * x_.length());
  }

 private:
  struct Span {
    float from, to;
    int first, last;  // the pixels that it covers a part of

    Span(float middle, float side, int size)
        : from(std::max(middle - 0.5f * side, 0.f)),
          to(std::min(middle + 0.5f * side, static_cast<float>(size))),
          first(std::min(static_cast<int>(from), size - 1)),
          last(std::max(first, static_cast<int>(std::ceil(to)) - 1)) {}
    float length() const { return to - from; }
    float covered(int pixel) const {
      const auto begin = static_cast<float>(pixel);
      return std::min(begin + 1, to) - std::max(begin, from);
    }
  };
  Span y_, x_;
};

}  // namespace hdrcam
