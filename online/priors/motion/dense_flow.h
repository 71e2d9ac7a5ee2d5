// Dense optical flow between two pictures, both ways: inverse search of patches from coarse to fine (DIS,
// Kroeger et al., ECCV 2016), and at each scale a robust smoothing where the pictures allow it (Brox et al.,
// ECCV 2004). At one coarse scale what is not explained is looked for in a third of the picture: an object
// that moves farther than its own size. On the processor (cpu_flow.h) or on a graphics device
// (vulkan/vulkan_flow.h); one that fails there goes on with the processor and says so. Thread-bound.
#pragma once

#include <memory>
#include <string>

#include "hal/core/image.h"
#include "online/priors/motion/motion_prior.h"

namespace hdrcam {

// Where a search starts: what each pixel's motion may be.
struct FlowGuess {
  const Image<float>* vectors = nullptr;  // [dx dy, rows, cols] pixels; null: no guess
  float scale = 1;
  bool carried = false;  // the vectors are of the other picture's pixels: they are read where they lead
};

// Pictures [1, rows, cols] of codes, 0..255, and the vectors [dx dy, rows, cols], pixels, that lead from each
// pixel of the one to where it is in the other.
struct FlowRequest {
  const Image<float>*a, *b;
  Image<float>*a_to_b, *b_to_a;
  FlowGuess start_a_to_b = {}, start_b_to_a = {};
};

class DenseFlow {
 public:
  static constexpr int kMinSize = 16;  // pixels: a smaller picture has no flow to find, the answer is zero

  virtual ~DenseFlow() = default;

  virtual void compute(FlowQuality quality, const FlowRequest& request) = 0;
  // Why it no longer runs where it was asked to; "" while it does.
  virtual std::string fallback_reason() const { return {}; }
};

// For pictures of rows x cols pixels. gpu: where to run, null for the processor, which is also taken in place
// of a software device; it outlives the flow, as the pool does. What keeps it from running there is in
// fallback_reason().
std::unique_ptr<DenseFlow> make_dense_flow(int rows, int cols, WorkerPool& pool, GpuDevice* gpu);

}  // namespace hdrcam
