// The online part of the pipeline, in processing order: what codes mean (sensor_model.h), from the first
// frames on; then for each frame motion and state, and the second layer: pose, depth and field
// (second_layer.h). Behind a cut all but the sensor begins anew (pictures/cut_watch.h). It delivers an
// estimate of each frame as soon as its look-ahead has arrived (pending_frames.h). Thread-bound;
// deterministic for any number of threads.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/compact_frame.h"
#include "hal/core/stage_timing.h"
#include "online/frame_estimate.h"
#include "online/knobs.h"
#include "online/pending_frames.h"
#include "online/pictures/cut_watch.h"
#include "online/recent_values.h"
#include "online/second_layer.h"
#include "online/sensor_model.h"
#include "online/state/state_layer.h"

namespace hdrcam {

class OnlineStage {
 public:
  using Emit = std::function<Result<void>(const FrameEstimate&)>;
  using LeftOut = std::function<void()>;

  // response: none where it is unknown and must be estimated. gpu: runs the flow and the state, fits and
  // renders the field; null for the processor; outlives the stage.
  OnlineStage(const Knobs& knobs, const CameraFacts& camera, const std::optional<Response>& response,
              WorkerPool& pool, GpuDevice* gpu = nullptr);

  // Takes the next frame, whose storage it exchanges, and emits the estimates that became ready. Where the
  // response is unknown, the frame has its black level still. budget: for all work in this call. Errors:
  // those of emit and of SceneField::observe.
  Result<void> ingest(ExposedFrame& frame, const FrameBudget& budget, const Emit& emit);
  // Ends the stream and emits the rest. Errors: as for ingest.
  Result<void> finish(const Emit& emit);

  void set_timing(const StageTiming& timing) {
    timing_ = timing;
    second_layer_.set_timing(timing);
  }
  // Called for each frame that became ready and is not emitted, because the budget said so.
  void set_left_out(LeftOut left_out) { left_out_ = std::move(left_out); }
  const SensorModel& sensor() const { return sensor_; }
  bool leaves_out_given_poses() const { return second_layer_.leaves_out_given_poses(); }
  // Why the state, the flow, or the fit of the field no longer runs on the graphics device; "" while it does,
  // or was not asked to.
  std::string fallback_reason() const { return state_->fallback_reason(); }
  std::string flow_fallback_reason() const { return motion_->fallback_reason(); }
  std::string field_fallback_reason() const { return second_layer_.fallback_reason(); }

 private:
  enum class Stream { GoesOn, Ended };  // ended: frames wait for no later ones

  // --- the way of a frame; place: in frames_ ---
  Result<void> bootstrap(const Emit& emit);
  Result<void> begin_anew(const ResponseEstimate& estimate, int frame, const Emit& emit);
  Result<void> end_scene(const Emit& emit);
  Result<void> emit_rest(const Emit& emit);
  Result<void> take(ExposedFrame& frame, const Emit& emit);
  Result<void> begin(PendingFrame& first, const ExposureTables& tables);
  void match(std::size_t place, const ExposureTables& tables);
  Result<void> advance(std::size_t place);
  Result<void> fit(PendingFrame& pending);
  Result<void> emit_ready(Stream stream, const Emit& emit);
  Result<void> emit_at(std::size_t place, std::size_t ahead, const Emit& emit);
  LaterFrame later_frame(std::size_t place, const ExposedFrame& emitted);

  SceneView view_of(const PendingFrame& pending) const;
  // Whether the newest frame joins the one that becomes ready.
  bool joins_newest() const {
    return look_ahead_ > 0 && budget_.later_frames >= look_ahead_ && budget_.emits;
  }
  bool second_layer_takes_part() const { return knobs_.field != FieldKind::None && !budget_.field_rests; }
  void note_darkest(const ExposureTables& tables);
  float white() const { return whites_.greatest(1); }
  std::array<float, 3> darkest() const;
  float unseen_variance() const { return unseen_variance_from(white()); }

  const Knobs knobs_;
  FrameBudget budget_;
  const CameraFacts camera_;
  const int look_ahead_;  // frames
  WorkerPool& pool_;
  GpuDevice* gpu_;                          // null: the processor
  std::vector<CompactFrame> first_frames_;  // until codes mean something

  std::unique_ptr<MotionPrior> motion_;
  std::unique_ptr<StateLayer> state_;
  SensorModel sensor_;
  SecondLayer second_layer_;
  RecentValues whites_;                   // radiance that saturates each exposure
  std::array<RecentValues, 3> darkests_;  // radiance up to which each of the state's frames is black
  PendingFrames frames_;
  CutWatch cuts_;
  JoinedState joined_;  // borrowed during an emission
  StageTiming timing_;
  LeftOut left_out_;
};

}  // namespace hdrcam
