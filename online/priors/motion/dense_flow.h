// Dense optical flow between two 8-bit pictures: DIS (Kroeger et al., ECCV 2016; OpenCV). Deterministic for
// any number of threads: each call runs on one thread, several calls in parallel. Thread-bound.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "online/priors/motion/motion_prior.h"

namespace hdrcam {

struct FlowRequest {
  const Image<std::uint8_t>* from;      // [1, rows, cols]
  const Image<std::uint8_t>* to;        // [1, rows, cols]
  Image<float>* flow;                   // [dx dy, rows, cols] pixels: where each pixel of `from` is in `to`
  const Image<float>* start = nullptr;  // an initial estimate, or null
};

class DenseFlow {
 public:
  static constexpr int kMinSize = 16;  // pixels: for a smaller picture the flow is zero

  explicit DenseFlow(WorkerPool& pool);
  ~DenseFlow();

  void compute(FlowQuality quality, std::initializer_list<FlowRequest> requests);

 private:
  struct Engine;
  WorkerPool& pool_;
  std::array<std::vector<std::unique_ptr<Engine>>, 3> engines_;  // by quality, created on first use
};

}  // namespace hdrcam
