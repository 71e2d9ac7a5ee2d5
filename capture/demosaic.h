// Bayer mosaic -> three full channels, along edges: green by the direction of the smaller gradient, corrected
// by the curvature of the colour that is there (Hamilton and Adams, "Adaptive color plan interpolation in
// single sensor color electronic camera", US 5629734, 1997), but never beyond its neighbours; red and blue by
// their difference to green. Scaling the codes scales the result, so an exposure passes through it as through
// a linear filter. Reentrant.
#pragma once

#include <cstdint>

#include "hal/core/frame.h"

namespace hdrcam {

constexpr bool is_bayer(PixelLayout layout) {
  return layout != PixelLayout::Rgb && layout != PixelLayout::Mono;
}

// mosaic: [1, rows, cols] codes of a Bayer layout, at least 2x2. rgb: [rgb, rows, cols] float in the same
// codes, clipped to 0 .. max_code. Beyond the border the mosaic is mirrored, which keeps its colours in
// phase.
void demosaic(const Image<std::uint16_t>& mosaic, PixelLayout layout, float max_code, Image<float>& rgb);

}  // namespace hdrcam
