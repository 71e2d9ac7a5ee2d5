// One HDR frame out of an estimate's state: what nobody saw stays a lower bound, the rest is shrunk with its
// known variance (for the output only). Thread-bound.
#pragma once

#include "online/frame_estimate.h"
#include "render/hdr_frame.h"
#include "render/shrinkage.h"

namespace hdrcam {

class Emission {
 public:
  explicit Emission(WorkerPool& pool) : pool_(pool), shrinkage_(pool) {}

  void render(const FrameEstimate& estimate, HdrFrame& frame);

 private:
  void judge(const FrameEstimate& estimate, float offset, HdrFrame& frame);

  WorkerPool& pool_;
  Shrinkage shrinkage_;
};

}  // namespace hdrcam
