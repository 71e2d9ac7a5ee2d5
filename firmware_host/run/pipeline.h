// Joins the stages of the method in processing order: raw frame -> exposed frame -> state (and field) -> HDR
// frame -> consumer. The same for live capture, recording and replay. Thread-bound; deterministic for any
// number of threads.
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
// What the field is for: to fill what no frame saw, or to be seen itself, which takes more steps of the fit.
enum class FieldUse { Fills, Seen };
// The knobs of a preset for one layer: the state alone needs no field.
PipelineOptions options_of(Preset preset, EmitLayer layer);
PipelineOptions options_of(const Settings& settings, FieldUse use);

class Pipeline {
 public:
  // An emitted frame with its estimate. Valid during the call.
  using Deliver = std::function<Result<void>(const HdrFrame&, const FrameEstimate&, const FrameRecord&)>;

  // gpu: what computes beside the processor, or null; it outlives the pipeline.
  Pipeline(const PipelineOptions& options, const CameraFacts& camera, WorkerPool& pool,
           GpuDevice* gpu = nullptr);

  // Takes the next frame. It leaves out a frame whose exposure is not proved or whose pixels are damaged.
  // Errors: BadExposure, SizeChanged, and those of `deliver`.
  Result<void> take(const RawFrame& raw, const Deliver& deliver);
  // Delivers the remaining frames. TooShort for a clip of one frame.
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
  FrameRecord record_;  // of the frame in progress; stages add to it
  std::optional<Instant> first_time_;
  int kept_out_ = 0;
};

}  // namespace hdrcam
