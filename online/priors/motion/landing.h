// Where what moves fast is on its way. A motion is known at the pixels that it starts from; the path over a
// clipped frame is sought from those that it leads to, where something else was before. So pixels that move
// fast are thrown ahead, into cells; the fastest of a cell stays, because what is in front mostly moves
// faster. What is written there is a guess: pixels of the cell's rest do not move so. Thread-bound.
#pragma once

#include "hal/core/image.h"
#include "online/priors/motion/flow_kernels.h"

namespace hdrcam {

// How many cells pixels take, along an axis.
constexpr int landing_cells(int pixels) { return (pixels + kLandingCell - 1) / kLandingCell; }

class Landing {
 public:
  Landing(int rows, int cols);  // of the picture

  // there, back: flows between two pictures, [dx dy, rows, cols] pixels. Each cell gets the motion of the
  // fastest pixel that is in it after `share` of that motion, of those that are faster than `least` pixels
  // and that both flows agree on; where there is none, that of the cells beside it.
  void throw_ahead(const Image<float>& there, const Image<float>& back, float least, float share);
  // [dx dy, cells down, cells across] pixels; kNowhere where nothing comes
  const Image<float>& cells() const { return cells_; }

 private:
  Image<float> landed_, cells_;
};

}  // namespace hdrcam
