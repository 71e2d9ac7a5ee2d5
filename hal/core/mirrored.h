// A picture beyond its border: mirrored about the pixels there, which keeps the colour phase of a mosaic.
// Reentrant.
#pragma once

#include <algorithm>

namespace hdrcam {

// The row (column) that stands in for this one, of `count`, at least one.
inline int mirrored(int i, int count) {
  if (i < 0) i = -i;
  return std::clamp(i < count ? i : 2 * (count - 1) - i, 0, count - 1);
}

}  // namespace hdrcam
