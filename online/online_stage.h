// The online part of the pipeline, in processing order: response, an unreported black level and noise from
// the first frames; then for each frame motion, state, pose, depth and field. It delivers an estimate of each
// frame as soon as its look-ahead has arrived. Thread-bound; deterministic for any number of threads.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "capture/compact_frame.h"
#include "hal/core/stage_timing.h"
#include "online/frame_estimate.h"
#include "online/knobs.h"
#include "online/noise/noise_estimator.h"
#include "online/response/response_learner.h"
#include "online/state/shown_blur.h"
#include "online/state/state_layer.h"
#include "online/state/texture_error.h"

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

  void set_timing(StageTiming timing) { timing_ = std::move(timing); }
  // Called for each frame that became ready and is not emitted, because the budget said so.
  void set_left_out(LeftOut left_out) { left_out_ = std::move(left_out); }
  const Response& response() const { return response_; }
  // False where no frames say anything about the response yet, and the mean of real cameras stands in.
  bool response_measured() const { return response_known_ || learner_.measured(); }
  // The frames, counted from 0, with which the response became another one.
  const std::vector<int>& relearned() const { return relearned_; }
  const NoiseModel& noise() const { return noise_; }         // at reference_gain()
  double reference_gain() const { return reference_gain_; }  // of the first frame
  const BlackLevel& black_level() const { return black_level_; }
  // The share of the local contrast that the camera's own processing leaves as error (texture_error.h).
  float texture_error() const { return texture_error_->share(); }
  // Whether frames show the motion blur that their exposure times state (shown_blur.h).
  bool blur_shown() const { return shown_blur_->shown(); }
  // Why the state, or the fit of the field, no longer runs on the graphics device; "" while it does, or was
  // not asked to.
  std::string trouble() const { return state_->trouble(); }
  std::string field_trouble() const { return field_ != nullptr ? field_->trouble() : std::string(); }

 private:
  struct Step;  // one frame in progress

  Result<void> bootstrap(const Emit& emit);
  void go_over_to(const ResponseEstimate& estimate);
  Result<void> begin_anew(const ResponseEstimate& estimate, const Emit& emit);
  std::unique_ptr<Step> spare_step();
  Result<void> take(ExposedFrame& frame, const Emit& emit);
  Result<void> advance(Step& step, const Step* after);
  Instant time_before(std::size_t at, std::size_t n) const;
  Result<void> fit(Step& step);
  void start_second_layer(const ExposedFrame& first);
  void keep_state(Step& step);
  void end_look_along(Step& step);
  std::optional<FramePose> stated_pose(const ExposedFrame& frame, const CameraPose& pose) const;
  Result<void> emit_step(std::size_t i, std::size_t ahead, const Emit& emit);
  Result<void> emit_ready(bool all, const Emit& emit);
  void retire_oldest();
  const ExposureTables& tables_for(const ExposedFrame& frame);
  static bool looks_closely(int frame);
  bool learns_noise(int frame) const { return knobs_.noise == NoiseKind::Learned && looks_closely(frame); }
  // Whether the newest frame joins the one that becomes ready.
  bool joins_newest() const {
    return look_ahead_ > 0 && budget_.later_frames >= look_ahead_ && budget_.emits;
  }
  bool field_takes_part() const { return knobs_.field != FieldKind::None && !budget_.field_rests; }
  void learn_noise(const Step& previous, const Step& step);
  float blur_of(const Step& step) const;
  void learn_blur(const Step& step);
  void learn_texture_error(const Step& step);
  void lower_darkest(const ExposureTables& tables);
  float gain_of(const ExposedFrame& frame) const;

  const Knobs knobs_;
  FrameBudget budget_;
  const CameraFacts camera_;
  const int look_ahead_;   // frames
  const int field_step_;   // px
  const Intrinsics lens_;  // assumed where the camera does not report it
  WorkerPool& pool_;
  GpuDevice* const gpu_;
  std::vector<CompactFrame> waiting_;  // until the bootstrap
  bool started_ = false;
  const bool response_known_;  // from the start

  ResponseLearner learner_;
  std::vector<int> relearned_;
  Response response_;
  BlackLevel black_level_;
  ExposureCorrections exposures_;
  NoiseOrigin noise_origin_ = NoiseOrigin::Unknown;
  NoiseModel assumed_noise_, noise_;  // before any measurement, and as measured so far
  std::optional<NoiseEstimator> noise_estimator_;
  std::optional<TextureError> texture_error_;
  std::optional<ShownBlur> shown_blur_;
  double reference_gain_ = 0;                                 // of the first frame; 0: none came yet
  std::map<std::pair<float, float>, ExposureTables> tables_;  // by exposure and gain

  std::unique_ptr<MotionPrior> motion_;
  std::unique_ptr<StateLayer> state_;
  float white_ = 1;  // radiance that saturates the shortest exposure so far
  static constexpr std::array<float, 3> kAllBlack{1e9f, 1e9f, 1e9f};
  std::array<float, 3> darkest_ = kAllBlack;  // radiance up to which even the longest one so far is black
  JoinedState joined_;                        // borrowed during an emission
  // created with the first frame that the field takes part in
  std::unique_ptr<PosePrior> poses_;
  std::unique_ptr<DepthPrior> depth_;
  const DepthMap* depth_map_ = nullptr;  // of the newest frame; the prior's
  std::unique_ptr<SceneField> field_;
  bool field_rested_ = false;                 // since its last frame
  int world_ = -1;                            // of the poses: counts their beginnings
  std::vector<std::unique_ptr<Step>> steps_;  // not yet emitted, oldest first; the newest in any case
  std::vector<std::unique_ptr<Step>> spare_;  // for reuse
  std::size_t retired_ = 0;                   // number of the frames before them
  std::array<Instant, 2> retired_times_{};    // of these the newest two, the newest first
  StageTiming timing_;
  LeftOut left_out_;
};

}  // namespace hdrcam
