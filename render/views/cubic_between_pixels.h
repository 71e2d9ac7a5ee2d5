// A picture of radiance between its pixels, sharper than bilinear: Catmull-Rom, kept near the bilinear value,
// so that edges of lamps do not ring. Borrows the picture. Reentrant.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "hal/core/subpixels.h"
#include "online/pictures/between_pixels.h"

namespace hdrcam {

class CubicBetweenPixels {
 public:
  // x, y: pixel centres at +0.5; outside, the nearest place inside.
  CubicBetweenPixels(const Image<float>& in, float x, float y)
      : in_(in),
        y_(rounded_tap(y - 0.5f, in.rows())),
        x_(rounded_tap(x - 0.5f, in.cols())),
        rows_(four_around(y_, in.rows())),
        cols_(four_around(x_, in.cols())),
        wy_(weights(y_.share)),
        wx_(weights(x_.share)) {}

  float value(int channel) const {
    constexpr float kLimit = 0.3f;  // of the bilinear value, up and down
    float sum = 0;
    for (std::size_t j = 0; j < 4; ++j) {
      const float* row = in_.row(channel, rows_[j]);
      sum += wy_[j] * (wx_[0] * row[cols_[0]] + wx_[1] * row[cols_[1]] + wx_[2] * row[cols_[2]] +
                       wx_[3] * row[cols_[3]]);
    }
    const float flat = BetweenPixels(y_, x_).of(in_, channel);
    return std::clamp(sum, (1 - kLimit) * flat, (1 + kLimit) * flat);
  }
  int nearest_row() const { return y_.share < 0.5f ? y_.low : y_.high; }
  int nearest_col() const { return x_.share < 0.5f ? x_.low : x_.high; }

 private:
  // Places are rounded to a part of a pixel: what does not move is copied, not interpolated.
  static AxisTap rounded_tap(float place, int size) {
    constexpr float kParts = subpixels::kSubpixels;
    return tap_at(std::round(std::clamp(place, 0.f, static_cast<float>(size - 1)) * kParts) / kParts, size);
  }
  static std::array<int, 4> four_around(AxisTap tap, int size) {
    return {std::max(tap.low - 1, 0), tap.low, tap.high, std::min(tap.low + 2, size - 1)};
  }
  static std::array<float, 4> weights(float t) {
    return {t * (-0.5f + t * (1 - 0.5f * t)), 1 + t * t * (-2.5f + 1.5f * t), t * (0.5f + t * (2 - 1.5f * t)),
            t * t * (-0.5f + 0.5f * t)};
  }

  const Image<float>& in_;
  AxisTap y_, x_;
  std::array<int, 4> rows_, cols_;
  std::array<float, 4> wy_, wx_;
};

}  // namespace hdrcam
