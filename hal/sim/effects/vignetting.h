// Vignetting: light falls with the fourth power of the cosine of its angle to the lens axis, times a strength
// (1: natural vignetting of a simple lens; 2: a fast lens wide open). Value type, reentrant.
#pragma once

#include "hal/core/frame.h"
#include "hal/core/image.h"
#include "hal/sim/geometry.h"

namespace hdrcam {

struct VignettingSettings {
  float strength = 1;  // exponent in units of cos^4
};

class Vignetting {
 public:
  // Precomputes the factor of each pixel of a picture of rows x cols.
  Vignetting(VignettingSettings settings, const Intrinsics& lens, int rows, int cols);

  float factor(int y, int x) const { return factor_.at(0, y, x); }
  // light: [rgb, rows, cols]; darkens row y.
  void apply_row(Image<float>& light, int y) const;

 private:
  Image<float> factor_;  // [1, rows, cols] 0..1
};

}  // namespace hdrcam
