// Bayer mosaic -> three full channels by gradient-corrected bilinear interpolation: Malvar, He and Cutler,
// "High-quality linear interpolation for demosaicing of Bayer-patterned color images", ICASSP 2004. Linear,
// 5x5, so that noise and exposure pass through it as through any linear filter. Reentrant.
#pragma once

#include <cstdint>

#include "hal/recording/recording.h"

namespace hdrcam {

constexpr bool is_bayer(PixelLayout layout) {
  return layout != PixelLayout::Rgb && layout != PixelLayout::Mono;
}

// mosaic: [1, rows, cols] codes of a Bayer layout, at least 2x2. rgb: [rgb, rows, cols] float in the same
// codes, clipped to 0 .. max_code. Beyond the border the mosaic is mirrored, which keeps its colours in
// phase.
void demosaic(const Image<std::uint16_t>& mosaic, PixelLayout layout, float max_code, Image<float>& rgb);

}  // namespace hdrcam
