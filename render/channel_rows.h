// The three channels of a line of a picture. Reentrant.
#pragma once

#include <array>

namespace hdrcam {

// picture: [rgb, rows, cols].
template <class Picture>
auto rows_of(Picture& picture, int y) {
  return std::array{picture.row(0, y), picture.row(1, y), picture.row(2, y)};
}

}  // namespace hdrcam
