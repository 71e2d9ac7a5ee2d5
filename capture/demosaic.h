// Bayer mosaic -> three full channels, along edges: green is interpolated in the direction of the smaller
// gradient and corrected by the curvature of the colour sampled there (Hamilton and Adams, "Adaptive color
// plan interpolation in single sensor color electronic camera", US 5629734, 1997), limited to the range of
// its neighbours; red and blue are interpolated as differences to green. Scaling the codes scales the result,
// so exposures can be compared after it as after a linear filter. Reentrant.
#pragma once

#include <cstdint>

#include "hal/core/frame.h"

namespace hdrcam {

// mosaic: [1, rows, cols] codes of a Bayer layout, at least 2x2. rgb: [rgb, rows, cols] float in the same
// codes, clipped to 0 .. max_code, times `scale`. The mosaic is mirrored at the border, which keeps its
// colour phase.
void demosaic(const Image<std::uint16_t>& mosaic, PixelLayout layout, float max_code, Image<float>& rgb,
              float scale = 1);

}  // namespace hdrcam
