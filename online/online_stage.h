// The online part of the pipeline, in the order of a frame's way: black level, response and noise from the
// first cycles; then for each frame motion, state, window and field. It hands out moments: all that an
// emission needs about one frame, as soon as its look-ahead has arrived. Thread-bound; deterministic whatever
// the number of threads.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "capture/unpack.h"
#include "online/field_stage.h"
#include "online/motion/state_motion.h"
#include "online/noise/noise_estimator.h"
#include "online/response/response_estimator.h"
#include "online/state/state_filter.h"

namespace hdrcam {

struct OnlineOptions {
  int look_ahead = 1;        // frames, 0..2: how many later frames an emission waits for
  int bootstrap_frames = 6;  // 2..: frames from which the response is estimated before the first emission
  FlowQuality flow = FlowQuality::Medium;
  float code_noise = 1;  // codes rms (NoiseModel)
  StateOptions state;
  std::optional<FieldStageOptions> field = std::nullopt;  // none: the state alone
};

// One frame ready to be emitted; everything is valid only during the call that hands it out.
struct Moment {
  struct Ahead {
    const ExposedFrame* frame;
    const FlowField* from_previous;  // from the frame before it
    const ExposureTables* tables;
  };
  const ExposedFrame* frame = nullptr;
  const RadianceState* state = nullptr;    // up to and with this frame
  const FlowField* to_previous = nullptr;  // null at the first frame
  std::span<const Ahead> ahead;            // the following frames, nearest first
  Fusion* fusion = nullptr;
  const FieldStage* field = nullptr;  // fitted up to and with this frame; null without the field
  const FitReport* fit = nullptr;     // the fit's work on this frame
  float white = 1;                    // radiance that saturates the shortest exposure
  double reference_exposure = 1;      // E_ref, seconds x gains
};

class OnlineStage {
 public:
  using Emit = std::function<Result<void>(const Moment&)>;
  using Timing = std::function<void(const char* stage, double ms)>;

  // response: none where unknown, to be estimated.
  OnlineStage(OnlineOptions options, const CameraFacts& camera, const std::optional<Response>& response,
              WorkerPool& pool);
  ~OnlineStage();

  // Takes the next frame; emits what became ready. Errors: BadExposure, and whatever emit returns.
  Result<void> ingest(const RawFrame& raw, const Emit& emit);
  // The stream has ended: emits the rest. TooShort for fewer than two frames.
  Result<void> finish(const Emit& emit);

  void set_timing(Timing timing) { timing_ = std::move(timing); }
  const Response& response() const { return response_; }
  const NoiseModel& noise() const { return noise_; }
  const BlackLevel& black_level() const { return settings_.black_level; }
  double reference_exposure() const { return settings_.reference_exposure; }

 private:
  struct Step;  // one frame on its way through

  Result<void> bootstrap(const Emit& emit);
  std::unique_ptr<Step> spare_step();
  Result<void> take(std::unique_ptr<Step> step, const Emit& emit);
  Result<void> advance(Step& step, const Step* after);
  Result<void> fit(Step& step, const StateMotion* motion);
  Result<void> emit_ready(bool all, const Emit& emit);
  const ExposureTables& tables_for(float exposure);
  void learn_noise(const Step& previous, const Step& step);

  OnlineOptions options_;
  const CameraFacts camera_;
  WorkerPool& pool_;
  UnpackSettings settings_;
  std::deque<RawFrame> waiting_;  // until the bootstrap
  bool started_ = false, response_known_ = false;
  int arrived_ = 0;
  Instant last_time_;

  Response response_;
  NoiseModel noise_;
  NoiseEstimator noise_estimator_;
  std::map<float, ExposureTables> tables_;

  MotionEstimator motion_;
  StateFilter filter_;
  std::unique_ptr<FieldStage> field_;         // made with the first frame
  std::vector<std::unique_ptr<Step>> steps_;  // not yet emitted, oldest first, and one before them
  std::vector<std::unique_ptr<Step>> spare_;  // to be used again
  Timing timing_;
};

}  // namespace hdrcam
