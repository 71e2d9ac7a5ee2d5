// How much of a large picture is looked at, so that the cost does not grow with it: every n-th line tells as
// much. Reentrant.
#pragma once

#include <algorithm>
#include <cstddef>

#include "hal/core/image.h"

namespace hdrcam {

// For statistics of the picture as a whole: n, so that about 200,000 pixels of each channel are looked at.
// codes: [channels, rows, cols].
inline int line_step(const Image<float>& codes) {
  constexpr std::size_t kEnoughPixels = 200'000;
  return static_cast<int>((codes.plane_size() + kEnoughPixels - 1) / kEnoughPixels);
}

inline constexpr int kUsualPixels = 320 * 240;

// For a few numbers of it: between the lines that are looked at, so that these are as many pixels as of one
// of 320x240, of which fewer were worse (docs/decisions/kernels.md); stride: between lines of such a picture.
inline int lines_apart(int rows, int cols, int stride) {
  return stride * std::max(1, rows * cols / kUsualPixels);
}

}  // namespace hdrcam
