// How much of a picture is looked at for its statistics as a whole: of large pictures every n-th line tells
// as much. Reentrant.
#pragma once

#include <cstddef>

#include "hal/core/image.h"

namespace hdrcam {

// n: so that about 200,000 pixels of each channel are looked at. codes: [channels, rows, cols].
inline int line_step(const Image<float>& codes) {
  constexpr std::size_t kEnoughPixels = 200'000;
  return static_cast<int>((codes.plane_size() + kEnoughPixels - 1) / kEnoughPixels);
}

}  // namespace hdrcam
