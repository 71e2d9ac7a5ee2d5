// From an estimate to the HDR frame that leaves: the state's emission, and the field where the state does not
// know. Each layer can be had alone. Thread-bound; deterministic whatever the number of threads.
#pragma once

#include <functional>

#include "render/emission.h"

namespace hdrcam {

enum class EmitLayer {
  Merged,  // the state, and the field where nobody saw the pixel
  State,   // the state alone; the field need not run
  Field,   // the field alone
};

struct RenderOptions {
  EmitLayer layer = EmitLayer::Merged;
  bool shows_field_flow = false;  // HdrFrame::field_flow
  // of the lower bound, > 1: how far the field may go above what clipped pixels prove
  float largest_answer = 4;
};

class RenderStage {
 public:
  using Timing = std::function<void(const char* stage, double ms)>;

  RenderStage(RenderOptions options, WorkerPool& pool) : options_(options), pool_(pool), emission_(pool) {}

  void set_timing(Timing timing) { timing_ = std::move(timing); }
  void render(const FrameEstimate& estimate, HdrFrame& frame);

 private:
  void look_into_field(const FrameEstimate& estimate, HdrFrame& frame);
  void take_all(HdrFrame& frame);
  void fill_unseen(const FrameEstimate& estimate, HdrFrame& frame);

  RenderOptions options_;
  WorkerPool& pool_;
  Emission emission_;
  FieldPicture view_;
  Image<float> radiance_;  // of the view, at full size
  Timing timing_;
};

}  // namespace hdrcam
