// How much of a large picture is looked at by those who want a few numbers of it: as many pixels as of one of
// 320x240, so that the cost does not grow with the picture. Of 320x240 itself fewer pixels were worse
// (docs/decisions/kernels.md). Reentrant.
#pragma once

#include <algorithm>

namespace hdrcam {

inline constexpr int kUsualPixels = 320 * 240;

// Between the lines that are looked at; stride: between them in a picture of at most the usual size.
inline int lines_apart(int rows, int cols, int stride) {
  return stride * std::max(1, rows * cols / kUsualPixels);
}

}  // namespace hdrcam
