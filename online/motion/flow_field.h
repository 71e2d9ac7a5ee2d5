// Dense motion between two pictures of one size: for each pixel of the first, where it is in the second.
// vectors: [dx dy, rows, cols] pixels; confidence: [1, rows, cols] 0..1 (forward-backward agreement, inside
// the frame).
#pragma once

#include "hal/core/image.h"

namespace hdrcam {

struct FlowField {
  Image<float> vectors;
  Image<float> confidence;

  bool empty() const { return vectors.empty(); }
};

}  // namespace hdrcam
