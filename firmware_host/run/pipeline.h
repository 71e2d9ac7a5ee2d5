// The one place where the parts are joined, in the order of a frame's way: raw frame -> exposed frame ->
// state (and field) -> HDR frame -> whoever takes it. The same for live capture, recording and replay.
// Thread-bound; deterministic whatever the number of threads.
#pragma once

#include <functional>
#include <optional>

#include "firmware_host/settings/settings.h"
#include "firmware_host/sinks/run_record.h"
#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/core/worker_pool.h"
#include "online/online_stage.h"
#include "render/render_stage.h"

namespace hdrcam {

struct PipelineOptions {
  Knobs knobs;
  RenderOptions render;
};
// What a preset means for one layer: the state alone needs no field.
PipelineOptions options_of(Preset preset, EmitLayer layer);
PipelineOptions options_of(const Settings& settings);

class Pipeline {
 public:
  // What leaves the pipeline, and what the method knows about it. Valid during the call.
  using Deliver = std::function<Result<void>(const HdrFrame&, const FrameEstimate&, const FrameRecord&)>;

  Pipeline(const PipelineOptions& options, const CameraFacts& camera, WorkerPool& pool);

  // A frame whose exposure is not proved, or whose pixels are damaged, is kept out. Errors: BadExposure,
  // SizeChanged, and what `deliver` returns.
  Result<void> take(const RawFrame& raw, const Deliver& deliver);
  // Delivers what is still on its way. TooShort for a clip of one frame.
  Result<void> finish(const Deliver& deliver);

  const OnlineStage& online() const { return online_; }
  int kept_out() const { return kept_out_; }  // frames

 private:
  Result<void> render(const FrameEstimate& estimate, const Deliver& deliver);

  const CameraFacts camera_;
  const FrameBudget budget_;
  OnlineStage online_;
  RenderStage render_;
  HdrFrame frame_;
  FrameRecord record_;  // of the frame on its way; stages add to it
  std::optional<Instant> first_time_;
  int kept_out_ = 0;
};

}  // namespace hdrcam
