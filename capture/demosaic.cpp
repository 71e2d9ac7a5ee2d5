#include "capture/demosaic.h"

#include <algorithm>
#include <array>

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
  CHECK(is_bayer(layout));
  return {};
}

// Mirrors about the border pixel, which has the colour phase of the pixel it stands for.
int mirrored(int i, int count) {
  if (i < 0) i = -i;
  if (i >= count) i = 2 * (count - 1) - i;
  return std::clamp(i, 0, count - 1);
}

// The 5x5 neighbourhood of one pixel, reduced to the sums of the paper's figure 2; coefficients are eighths.
struct Neighbourhood {
  std::array<const std::uint16_t*, 5> row;
  std::array<int, 5> col;

  float at(int dy, int dx) const {
    return static_cast<float>(row[static_cast<std::size_t>(dy + 2)][col[static_cast<std::size_t>(dx + 2)]]);
  }
  float centre() const { return at(0, 0); }
  float across() const { return at(0, -1) + at(0, 1); }
  float down() const { return at(-1, 0) + at(1, 0); }
  float across2() const { return at(0, -2) + at(0, 2); }
  float down2() const { return at(-2, 0) + at(2, 0); }
  float diagonal() const { return at(-1, -1) + at(-1, 1) + at(1, -1) + at(1, 1); }

  float green() const { return (4 * centre() + 2 * (across() + down()) - across2() - down2()) / 8; }
  // a colour at a green pixel whose neighbours of that colour lie across, or down
  float colour_across() const {
    return (5 * centre() + 4 * across() - across2() - diagonal() + 0.5f * down2()) / 8;
  }
  float colour_down() const {
    return (5 * centre() + 4 * down() - down2() - diagonal() + 0.5f * across2()) / 8;
  }
  // red at blue, blue at red
  float opposite() const { return (6 * centre() + 2 * diagonal() - 1.5f * (across2() + down2())) / 8; }
};

}  // namespace

void demosaic(const Image<std::uint16_t>& mosaic, PixelLayout layout, float max_code, Image<float>& rgb) {
  const int rows = mosaic.rows(), cols = mosaic.cols();
  CHECK_LE(2, std::min(rows, cols));
  const RedAt red = red_at(layout);
  rgb.reshape(3, rows, cols);
  Neighbourhood near{};
  for (int y = 0; y < rows; ++y) {
    for (int d = -2; d <= 2; ++d)
      near.row[static_cast<std::size_t>(d + 2)] = mosaic.row(0, mirrored(y + d, rows));
    const bool red_row = (y & 1) == red.y;
    for (int x = 0; x < cols; ++x) {
      for (int d = -2; d <= 2; ++d) near.col[static_cast<std::size_t>(d + 2)] = mirrored(x + d, cols);
      const bool red_col = (x & 1) == red.x;
      std::array<float, 3> colour{};
      if (red_row == red_col) {  // a red or a blue pixel
        colour = {near.opposite(), near.green(), near.opposite()};
        colour[red_row ? 0 : 2] = near.centre();
      } else {  // green: the colour of its row lies across, the other one down
        colour[1] = near.centre();
        colour[red_row ? 0 : 2] = near.colour_across();
        colour[red_row ? 2 : 0] = near.colour_down();
      }
      for (int c = 0; c < 3; ++c)
        rgb.at(c, y, x) = std::clamp(colour[static_cast<std::size_t>(c)], 0.f, max_code);
    }
  }
}

}  // namespace hdrcam
