// Where no frame saw a channel unclipped the state holds a lower bound. The field raises it by half of the
// stops that it says, which is nearer to the truth than either. Thread-bound; deterministic for any number of
// threads.
#pragma once

#include "hal/core/worker_pool.h"
#include "online/frame_estimate.h"
#include "render/hdr_frame.h"

namespace hdrcam {

class UnseenFill {
 public:
  // largest_ratio: of the field's radiance to the bound (RenderOptions::largest_field_ratio).
  UnseenFill(float largest_ratio, WorkerPool& pool) : largest_ratio_(largest_ratio), pool_(pool) {}

  // Marks what unseen pixels read of the view reduced by `step`; false where every pixel was seen.
  bool mark(const FrameEstimate& estimate, int step);
  // [1, rows, cols] of that view: 1 where an unseen pixel reads it.
  const Image<std::uint8_t>& marked() const { return marked_; }

  // field: the radiance of that view, at least where it is marked.
  void raise(const FrameEstimate& estimate, const Image<float>& field, int step, HdrFrame& frame) const;

 private:
  float largest_ratio_;
  WorkerPool& pool_;
  Image<std::uint8_t> marked_;
};

}  // namespace hdrcam
