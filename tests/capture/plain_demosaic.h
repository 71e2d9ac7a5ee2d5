// Demosaicing pixel by pixel, in the order of capture/demosaic.h's description: what its kernels are compared
// with.
#pragma once

#include <algorithm>
#include <cmath>

#include "hal/core/image.h"

namespace hdrcam::test {

// The parities of the columns and the rows of red pixels.
struct RedAt {
  int x, y;
};

// Mirrors about the border pixel, which keeps the colour phase.
inline int mirrored(int i, int count) {
  if (i < 0) i = -i;
  if (i >= count) i = 2 * (count - 1) - i;
  return std::clamp(i, 0, count - 1);
}

// One line through a red or blue pixel: the two greens beside it and the two samples of its own colour beyond
// them.
struct Line {
  float gradient, green;
};
inline Line along(float far_before, float green_before, float own, float green_after, float far_after) {
  const float bend = 2 * own - far_before - far_after;
  // The curvature of the sampled colour sharpens the green, limited to the range of the neighbouring greens:
  // beside a clipped region it would ring otherwise.
  const float green = std::clamp((green_before + green_after) / 2 + bend / 4,
                                 std::min(green_before, green_after), std::max(green_before, green_after));
  return {std::abs(green_before - green_after) + std::abs(bend), green};
}

// Green where the mosaic has none, interpolated along the line with the smaller gradient.
inline void fill_green(const Image<std::uint16_t>& mosaic, RedAt red, float* green) {
  const int rows = mosaic.rows(), cols = mosaic.cols();
  for (int y = 0; y < rows; ++y) {
    const auto row = [&](int dy) { return mosaic.row(0, mirrored(y + dy, rows)); };
    const std::uint16_t* const near[5] = {row(-2), row(-1), row(0), row(1), row(2)};
    float* out = green + static_cast<std::size_t>(y) * static_cast<std::size_t>(cols);
    for (int x = 0; x < cols; ++x) {
      const float own = near[2][x];
      if (((x ^ red.x) & 1) != ((y ^ red.y) & 1)) {
        out[x] = own;
        continue;
      }
      const int a = mirrored(x - 2, cols), b = mirrored(x - 1, cols), d = mirrored(x + 1, cols),
                e = mirrored(x + 2, cols);
      const Line across = along(near[2][a], near[2][b], own, near[2][d], near[2][e]);
      const Line down = along(near[0][x], near[1][x], own, near[3][x], near[4][x]);
      out[x] = across.gradient < down.gradient   ? across.green
               : down.gradient < across.gradient ? down.green
                                                 : (across.green + down.green) / 2;
    }
  }
}

// The differences of one colour to green where the mosaic has that colour: smooth, as colours change less
// than light.
class Difference {
 public:
  Difference(const Image<std::uint16_t>& mosaic, const Image<float>& rgb) : mosaic_(mosaic), rgb_(rgb) {}
  float at(int y, int x) const {
    const int v = mirrored(y, mosaic_.rows()), u = mirrored(x, mosaic_.cols());
    return static_cast<float>(mosaic_.at(0, v, u)) - rgb_.at(1, v, u);
  }

 private:
  const Image<std::uint16_t>& mosaic_;
  const Image<float>& rgb_;
};

// channel: 0 or 2; (sy, sx): the parity of the pixels that have it.
inline void fill_colour(const Image<std::uint16_t>& mosaic, int channel, int sy, int sx, Image<float>& rgb) {
  const Difference difference(mosaic, rgb);
  for (int y = 0; y < mosaic.rows(); ++y) {
    const float* green = rgb.row(1, y);
    float* out = rgb.row(channel, y);
    const bool own_row = (y & 1) == sy;
    for (int x = 0; x < mosaic.cols(); ++x) {
      const bool own_col = (x & 1) == sx;
      if (own_row && own_col) {
        out[x] = static_cast<float>(mosaic.at(0, y, x));
      } else if (own_row) {
        out[x] = green[x] + (difference.at(y, x - 1) + difference.at(y, x + 1)) / 2;
      } else if (own_col) {
        out[x] = green[x] + (difference.at(y - 1, x) + difference.at(y + 1, x)) / 2;
      } else {  // of the two diagonals, the one along which the difference changes less
        const float a = difference.at(y - 1, x - 1), b = difference.at(y + 1, x + 1),
                    c = difference.at(y - 1, x + 1), d = difference.at(y + 1, x - 1);
        const float falling = std::abs(a - b), rising = std::abs(c - d);
        out[x] = green[x] + (falling < rising   ? (a + b) / 2
                             : rising < falling ? (c + d) / 2
                                                : (a + b + c + d) / 4);
      }
    }
  }
}

inline void plain_demosaic(const Image<std::uint16_t>& mosaic, RedAt red, float max_code, Image<float>& rgb) {
  rgb.reshape(3, mosaic.rows(), mosaic.cols());
  fill_green(mosaic, red, rgb.plane(1));
  fill_colour(mosaic, 0, red.y, red.x, rgb);
  fill_colour(mosaic, 2, 1 - red.y, 1 - red.x, rgb);
  for (float& code : rgb.samples()) code = std::clamp(code, 0.f, max_code);
}

}  // namespace hdrcam::test
