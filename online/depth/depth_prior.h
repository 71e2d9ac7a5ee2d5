// What is known of the scene's depth before the field is fitted: a guide for its samples, right or wrong per
// pixel, with a weight that says how much to believe it. inverse_depth: [1, rows, cols] 1 / camera z, in 1 /
// unit of length of the poses, >= 0, finite. weight: [1, rows, cols] 0..1: d^2 / (d^2 + sigma_d^2); 0 unknown
// or moving, 0.5 known to 100 percent.
#pragma once

#include "hal/core/image.h"

namespace hdrcam {

struct DepthPrior {
  Image<float> inverse_depth;
  Image<float> weight;

  bool empty() const { return weight.empty(); }
};

}  // namespace hdrcam
