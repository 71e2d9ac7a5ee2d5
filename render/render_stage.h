// From an estimate to the emitted HDR frame: the state, and the field where the state has no value. Each
// layer can also be emitted alone. Thread-bound; deterministic for any number of threads.
#pragma once

#include <optional>

#include "hal/core/stage_timing.h"
#include "render/emission.h"
#include "render/rolling_shutter.h"
#include "render/unseen_fill.h"

namespace hdrcam {

enum class EmitLayer {
  Merged,  // the state, raised at unseen pixels where the field says so
  State,   // the state alone; the field is not needed
  Field,   // the field alone
};

// How much of the scene's depth is rendered for each frame (HdrFrame::depth).
enum class DepthLayer {
  None,
  Glance,  // from few rays: enough to look at
  Whole,   // as finely as the field is rendered (FrameBudget::render_step)
};

struct RenderOptions {
  EmitLayer layer = EmitLayer::Merged;
  DepthLayer depth = DepthLayer::None;
  bool shows_flow_backward = false;  // HdrFrame::flow
  bool shows_flow_forward = false;   // HdrFrame::flow_forward
  bool shows_field_flow = false;     // HdrFrame::field_flow and field_flow_forward
  bool shows_points = false;         // HdrFrame::points
  // of the field's radiance to the lower bound of a clipped pixel, > 1: the field's is cut there, so that a
  // pixel rises by at most its square root
  float largest_field_ratio = 4;
  std::optional<double> readout_s = {};  // of a rolling shutter; none: as the frames state it
};

class RenderStage {
 public:
  // gpu: what computes beside the processor, or null; it outlives the stage.
  RenderStage(RenderOptions options, WorkerPool& pool, GpuDevice* gpu = nullptr)
      : options_(options),
        pool_(pool),
        emission_(pool, gpu),
        rolling_shutter_(pool),
        unseen_(options.largest_field_ratio, pool) {}

  void set_timing(StageTiming timing) { timing_ = std::move(timing); }
  void render(const FrameEstimate& estimate, HdrFrame& frame);

 private:
  void render_as_read(const FrameEstimate& estimate, HdrFrame& frame);
  void show_motion_and_points(const FrameEstimate& estimate, HdrFrame& frame);
  void render_field(const FrameEstimate& estimate, int step, HdrFrame& frame);
  void emit_field(const FrameEstimate& estimate, HdrFrame& frame);
  std::optional<int> step_of_layers(int render_step) const;
  void fill_unseen(const FrameEstimate& estimate, HdrFrame& frame);

  RenderOptions options_;
  WorkerPool& pool_;
  Emission emission_;
  RollingShutterCorrection rolling_shutter_;
  UnseenFill unseen_;
  FieldPicture view_;
  StageTiming timing_;
};

}  // namespace hdrcam
