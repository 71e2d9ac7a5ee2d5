// The scene's depth before the field is fitted: it guides the field's samples, with a confidence weight per
// pixel. This is the interface for a learned depth: it gets the frame and the state too. Thread-bound; the
// result does not depend on the number of threads.
#pragma once

#include <algorithm>

#include "hal/core/image.h"
#include "online/priors/pose/pose_prior.h"
#include "online/priors/seen_frame.h"

namespace hdrcam {

// A depth map on a grid over the picture, a point in each square of step_px pixels. inverse_depth: [1, rows,
// cols] 1 / camera z, in 1 / unit of length of the poses, >= 0, finite. weight: [1, rows, cols] 0..1: d^2 /
// (d^2 + sigma_d^2); 0 unknown or dynamic, 0.5 where sigma_d equals d.
struct DepthMap {
  static constexpr float kBelieved = 0.5f;  // weight from which on a depth counts

  Image<float> inverse_depth;
  Image<float> weight;
  int step_px = 1;

  // The row (column) of the picture, of so many, that a row (column) of the map stands for.
  int pixel_of(int point, int pixels) const { return std::min(point * step_px + step_px / 2, pixels - 1); }

  void copy_from(const DepthMap& other) {
    inverse_depth.copy_from(other.inverse_depth);
    weight.copy_from(other.weight);
    step_px = other.step_px;
  }
  bool empty() const { return weight.empty(); }
  // Whether anything of the picture has a depth that counts.
  bool tells() const {
    return std::ranges::any_of(weight.samples(), [](float w) { return w >= kBelieved; });
  }
};

class DepthPrior {
 public:
  virtual ~DepthPrior() = default;
  // Estimates the depth of this frame, given its pose. The map belongs to the prior until the next call.
  virtual const DepthMap& estimate(const SeenFrame& seen, const CameraPose& pose) = 0;
};

}  // namespace hdrcam
