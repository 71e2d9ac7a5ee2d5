// The online part of the pipeline, in processing order: what codes mean (sensor_model.h), from the first
// frames on; then for each frame motion and state, and the second layer: pose, depth and field
// (second_layer.h). It delivers an estimate of each frame as soon as its look-ahead has arrived.
// Thread-bound; deterministic for any number of threads.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "capture/compact_frame.h"
#include "hal/core/stage_timing.h"
#include "online/frame_estimate.h"
#include "online/knobs.h"
#include "online/second_layer.h"
#include "online/sensor_model.h"
#include "online/state/state_layer.h"

namespace hdrcam {

class OnlineStage {
 public:
  using Emit = std::function<Result<void>(const FrameEstimate&)>;
  using LeftOut = std::function<void()>;

  // response: none where it is unknown and must be estimated. gpu: runs the state, fits and renders the
  // field; null for the processor; outlives the stage.
  OnlineStage(const Knobs& knobs, const CameraFacts& camera, const std::optional<Response>& response,
              WorkerPool& pool, GpuDevice* gpu = nullptr);
  ~OnlineStage();

  // Takes the next frame, whose storage it exchanges, and emits the estimates that became ready. Where the
  // response is unknown, the frame has its black level still. budget: for all work in this call. Errors:
  // those of emit.
  Result<void> ingest(ExposedFrame& frame, const FrameBudget& budget, const Emit& emit);
  // Ends the stream and emits the rest.
  Result<void> finish(const Emit& emit);

  void set_timing(const StageTiming& timing) {
    timing_ = timing;
    second_layer_.set_timing(timing);
  }
  // Called for each frame that became ready and is not emitted, because the budget said so.
  void set_left_out(LeftOut left_out) { left_out_ = std::move(left_out); }
  const SensorModel& sensor() const { return sensor_; }
  // Why the state, the flow, or the fit of the field no longer runs on the graphics device; "" while it does,
  // or was not asked to.
  std::string fallback_reason() const { return state_->fallback_reason(); }
  std::string flow_fallback_reason() const { return motion_->fallback_reason(); }
  std::string field_fallback_reason() const { return second_layer_.fallback_reason(); }

 private:
  struct Step;  // one frame in progress

  Result<void> bootstrap(const Emit& emit);
  Result<void> begin_anew(const ResponseEstimate& estimate, int frame, const Emit& emit);
  std::unique_ptr<Step> spare_step();
  Result<void> take(ExposedFrame& frame, const Emit& emit);
  Result<void> advance(Step& step, const Step* after);
  Instant time_before(std::size_t at, std::size_t n) const;
  float before_ratio(std::size_t at) const;
  Result<void> fit(Step& step);
  void keep(Step& step);
  void end_look_along(Step& step);
  Result<void> emit_step(std::size_t i, std::size_t ahead, const Emit& emit);
  Result<void> emit_ready(bool all, const Emit& emit);
  void retire_oldest();
  // Whether the newest frame joins the one that becomes ready.
  bool joins_newest() const {
    return look_ahead_ > 0 && budget_.later_frames >= look_ahead_ && budget_.emits;
  }
  bool second_layer_takes_part() const { return knobs_.field != FieldKind::None && !budget_.field_rests; }
  void lower_darkest(const ExposureTables& tables);
  float unseen_variance() const { return unseen_variance_from(white_); }

  const Knobs knobs_;
  FrameBudget budget_;
  const CameraFacts camera_;
  const int look_ahead_;  // frames
  WorkerPool& pool_;
  GpuDevice* gpu_;                     // null: the processor
  std::vector<CompactFrame> waiting_;  // until codes mean something

  std::unique_ptr<MotionPrior> motion_;
  std::unique_ptr<StateLayer> state_;
  SensorModel sensor_;
  SecondLayer second_layer_;
  float white_ = 1;  // radiance that saturates the shortest exposure so far
  static constexpr std::array<float, 3> kAllBlack{1e9f, 1e9f, 1e9f};
  std::array<float, 3> darkest_ = kAllBlack;  // radiance up to which even the longest one so far is black
  JoinedState joined_;                        // borrowed during an emission
  std::vector<std::unique_ptr<Step>> steps_;  // not yet emitted, oldest first; the newest in any case
  std::vector<std::unique_ptr<Step>> spare_;  // for reuse
  std::size_t retired_ = 0;                   // number of the frames before them
  std::array<Instant, 2> retired_times_{};    // of these the newest two, the newest first
  StageTiming timing_;
  LeftOut left_out_;
};

}  // namespace hdrcam
