// Makes one HDR frame from an estimate's state: unseen pixels stay lower bounds, the others are shrunk with
// their known variance (for the output only). Thread-bound.
#pragma once

#include "online/frame_estimate.h"
#include "render/hdr_frame.h"
#include "render/shrinkage.h"

namespace hdrcam {

class Emission {
 public:
  // gpu: which shrinks, null for the processor; it outlives the emission.
  explicit Emission(WorkerPool& pool, GpuDevice* gpu = nullptr) : pool_(pool), shrinkage_(pool, gpu) {}

  void render(const FrameEstimate& estimate, HdrFrame& frame);

 private:
  void judge(const FrameEstimate& estimate, float offset, HdrFrame& frame);

  WorkerPool& pool_;
  Shrinkage shrinkage_;
};

}  // namespace hdrcam
