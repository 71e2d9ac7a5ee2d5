// Joins the stages of the method in processing order: raw frame -> exposed frame -> state (and field) -> HDR
// frame -> consumer. The same for live capture, recording and replay. Thread-bound; deterministic for any
// number of threads.
#pragma once

#include <functional>
#include <optional>

#include "capture/exposed_stream.h"
#include "firmware_host/run/frame_work.h"
#include "firmware_host/run/pipeline_options.h"
#include "firmware_host/sinks/run_record.h"
#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/core/trace.h"
#include "hal/core/worker_pool.h"
#include "online/online_stage.h"
#include "render/render_stage.h"

namespace hdrcam {

// Whether a frame has no part in the fit: its exposure is not proved, or its pixels are damaged.
inline bool is_kept_out(const FrameFacts& facts) {
  return (facts.flags & (kFrameExposureUnproved | kFrameDamaged)) != 0;
}

class Pipeline {
 public:
  // An emitted frame, which the receiver may change, with its estimate. Valid during the call.
  using Deliver = std::function<Result<void>(HdrFrame&, const FrameEstimate&, const FrameRecord&)>;
  // A frame that is not emitted, because its budget said so.
  using LeftOut = std::function<void()>;

  // gpu: what computes beside the processor, or null; it outlives the pipeline.
  Pipeline(const PipelineOptions& options, const CameraFacts& camera, WorkerPool& pool,
           GpuDevice* gpu = nullptr);

  // Takes the next frame. It keeps out a frame whose exposure is not proved or whose pixels are damaged.
  // budget: of this call; without it, that of the options. Errors: BadExposure, SizeChanged, and those of
  // `deliver`.
  Result<void> take(const RawFrame& raw, const FrameBudget& budget, const Deliver& deliver);
  Result<void> take(const RawFrame& raw, const Deliver& deliver) { return take(raw, budget_, deliver); }
  // Delivers the remaining frames. TooShort for a clip of one frame.
  Result<void> finish(const Deliver& deliver);

  // trace: gets every stage as a span; null, or outlives the pipeline.
  void set_trace(Trace* trace) { trace_ = trace; }

  void set_left_out(LeftOut left_out) { left_out_ = std::move(left_out); }
  const OnlineStage& online() const { return online_; }
  // Of the last call of take(); of finish() the frames alone.
  const FrameWork& work() const { return work_; }
  int kept_out() const { return kept_out_; }  // frames

 private:
  Pipeline(const PipelineOptions& options, const CameraFacts& camera, const std::optional<Response>& response,
           WorkerPool& pool, GpuDevice* gpu);
  Result<void> ingest(ExposedFrame& frame, const FrameBudget& budget, const Deliver& deliver);
  Result<void> render(const FrameEstimate& estimate, const Deliver& deliver);

  const CameraFacts camera_;
  const FrameBudget budget_;
  ExposedStream exposed_;
  OnlineStage online_;
  RenderStage render_;
  HdrFrame frame_;
  FrameRecord record_;  // of the frame in progress; stages add to it
  FrameWork work_;
  LeftOut left_out_;
  std::optional<Instant> first_time_;
  int kept_out_ = 0;
  Trace* trace_ = nullptr;
};

}  // namespace hdrcam
