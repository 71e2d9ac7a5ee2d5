#include "capture/demosaic.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include "capture/demosaic_kernels.h"
#include "hal/core/mirrored.h"

namespace hdrcam {
namespace {

// Whether red lies on even columns and even rows of the layout.
struct RedAt {
  int x, y;
};
RedAt red_at(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::BayerRggb:
      return {0, 0};
    case PixelLayout::BayerGrbg:
      return {1, 0};
    case PixelLayout::BayerGbrg:
      return {0, 1};
    case PixelLayout::BayerBggr:
      return {1, 1};
    case PixelLayout::Rgb:
    case PixelLayout::Mono:
      break;
  }
  HDRCAM_CHECK(is_bayer(layout));
  return {};
}

}  // namespace

void demosaic(const Image<std::uint16_t>& mosaic, PixelLayout layout, float max_code, Image<float>& rgb,
              float scale) {
  const int rows = mosaic.rows(), cols = mosaic.cols();
  HDRCAM_CHECK_LE(2, std::min(rows, cols));
  const RedAt red = red_at(layout);
  const DemosaicKernels& kernels = demosaic_kernels();
  rgb.reshape(3, rows, cols);
  const auto mosaic_row = [&](int y) { return mosaic.row(0, mirrored(y, rows)); };
  const auto fill_green = [&](int y) {
    kernels.green({.mosaic = {mosaic_row(y - 2), mosaic_row(y - 1), mosaic_row(y), mosaic_row(y + 1),
                              mosaic_row(y + 2)},
                   .lacking = (y & 1) == red.y ? red.x : 1 - red.x,
                   .green = rgb.row(1, y)},
                  cols);
  };
  const auto green_row = [&](int y) -> const float* { return rgb.row(1, mirrored(y, rows)); };
  const auto fill_colour = [&](int channel, int y) {
    const bool is_red = channel == 0;
    kernels.colour({.mosaic = {mosaic_row(y - 1), mosaic_row(y), mosaic_row(y + 1)},
                    .green = {green_row(y - 1), green_row(y), green_row(y + 1)},
                    .is_in_row = ((y & 1) == red.y) == is_red,
                    .having = is_red ? red.x : 1 - red.x,
                    .most = max_code,
                    .scale = scale,
                    .out = rgb.row(channel, y)},
                   cols);
  };
  const auto finish_green = [&](int y) {
    for (float& code : std::span(rgb.row(1, y), static_cast<std::size_t>(cols)))
      code = std::clamp(code, 0.f, max_code) * scale;
  };
  // a row behind the other, so that rows between are still in the cache
  fill_green(0);
  for (int y = 0; y < rows; ++y) {
    if (y + 1 < rows) fill_green(y + 1);
    fill_colour(0, y), fill_colour(2, y);
    if (y > 0) finish_green(y - 1);
  }
  finish_green(rows - 1);
}

}  // namespace hdrcam
