// Bayer mosaic: each pixel keeps one of three colours. Value type, reentrant.
#pragma once

#include <span>

#include "hal/core/frame.h"
#include "hal/core/image.h"

namespace hdrcam {

class Mosaic {
 public:
  // layout: one of the Bayer orders
  explicit Mosaic(PixelLayout layout);

  // 0 red, 1 green, 2 blue
  int channel(int y, int x) const { return channels_[y & 1][x & 1]; }
  // light: [rgb, rows, cols] -> row y behind the colour filter
  void pick_row(const Image<float>& light, int y, std::span<float> row) const {
    const float* even = light.row(channels_[y & 1][0], y);
    const float* odd = light.row(channels_[y & 1][1], y);
    for (std::size_t x = 0; x < row.size(); ++x) row[x] = (x & 1) == 0 ? even[x] : odd[x];
  }

 private:
  int channels_[2][2];
};

inline Mosaic::Mosaic(PixelLayout layout) : channels_{{0, 1}, {1, 2}} {
  HDRCAM_CHECK(is_bayer(layout));
  const auto order = [this](int a, int b, int c, int d) {
    channels_[0][0] = a, channels_[0][1] = b, channels_[1][0] = c, channels_[1][1] = d;
  };
  if (layout == PixelLayout::BayerGrbg) order(1, 0, 2, 1);
  if (layout == PixelLayout::BayerGbrg) order(1, 2, 0, 1);
  if (layout == PixelLayout::BayerBggr) order(2, 1, 1, 0);
}

}  // namespace hdrcam
