// What is known of the scene's depth before the field is fitted: a guide for its samples, right or wrong per
// pixel, with a weight that says how much to believe it. The seam for a learned depth: it has the frame and
// the state too. Thread-bound; the result does not depend on the number of threads.
#pragma once

#include "hal/core/image.h"
#include "online/priors/pose/pose_prior.h"
#include "online/priors/seen_frame.h"

namespace hdrcam {

// On any grid over the picture. inverse_depth: [1, rows, cols] 1 / camera z, in 1 / unit of length of the
// poses, >= 0, finite. weight: [1, rows, cols] 0..1: d^2 / (d^2 + sigma_d^2); 0 unknown or moving, 0.5 known
// to 100 percent.
struct DepthMap {
  Image<float> inverse_depth;
  Image<float> weight;

  bool empty() const { return weight.empty(); }
};

class DepthPrior {
 public:
  virtual ~DepthPrior() = default;
  // The depth of this frame, given its pose. The map belongs to the prior until the next call.
  virtual const DepthMap& estimate(const SeenFrame& seen, const CameraPose& pose) = 0;
};

}  // namespace hdrcam
