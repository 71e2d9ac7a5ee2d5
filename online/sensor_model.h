// What a camera's codes mean and how far they are right: its response and black level, its noise, the error
// that its own processing leaves in textures, and how much of the stated motion blur its frames show. It
// learns them from the first frames and goes on while the stream runs, by comparing new frames with the
// state. Thread-bound; the result does not depend on the number of threads.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "capture/compact_frame.h"
#include "online/knobs.h"
#include "online/noise/noise_estimator.h"
#include "online/response/response_learner.h"
#include "online/state/frame_light.h"
#include "online/state/shown_blur.h"
#include "online/state/state_layer.h"
#include "online/state/texture_error.h"

namespace hdrcam {

class SensorModel {
 public:
  // response: where it is known, and frames come without their black level; else it is learned, too. state:
  // what frames are compared with; it and the pool outlive the model.
  SensorModel(const Knobs& knobs, const CameraFacts& camera, const std::optional<Response>& response,
              const StateLayer& state, WorkerPool& pool);

  // --- the way of a frame, in this order ---
  // Takes note of what the frame states. Where the response is unknown, it has its black level still.
  void meet(const ExposedFrame& frame);
  // Whether codes mean something: first frames are seen, and wait until there are enough for learn_first().
  bool is_known() const { return known_; }
  // before: the frame before it, or null.
  void see_first(const ExposedFrame& frame, const CompactFrame* before) { learner_.see_first(frame, before); }
  void learn_first(std::span<const CompactFrame> frames);
  // Where this frame shows the response to be another one, what it is: the caller ends what goes on under the
  // last one and calls begin_anew(). Nearly always nothing.
  std::optional<ResponseEstimate> learn_response(const ExposedFrame& frame);
  // Under another response the same codes are other radiances: nothing that was learned under the last one
  // holds. frame: the index of the first that comes under it.
  void begin_anew(const ResponseEstimate& estimate, int frame);
  // Removes a black level that was learned, and corrects the exposure.
  void correct(ExposedFrame& frame) const;
  // The share of the motion that counts as the frame's blur becomes its blur_fraction; returns the stated
  // one.
  float count_blur(ExposedFrame& frame) const;
  // Compares the frame with the state of the frame before. motion: from its pixels to the state's; stated: as
  // count_blur() returned it; unseen_variance: from which on a pixel of the state counts as unseen.
  void compare(const ExposedFrame& frame, float stated, const FlowField& motion, float unseen_variance);
  // Where light is unsteady, the frame's own light becomes part of its exposure. motion: from its pixels to
  // the state's.
  void follow_light(ExposedFrame& frame, const FlowField& motion, float unseen_variance);
  // Whether learn_noise() wants the pair that the frame makes with the one before it.
  bool learns_noise(const ExposedFrame& frame) const;
  // motion: between the two, rated along the pixels of the shorter exposure (noise_is_seen_in_newer).
  void learn_noise(const ExposedFrame& older, const ExposedFrame& newer, const StateMotion& motion);
  // The noise of two frames is compared at the pixels of the shorter exposure.
  static bool noise_is_seen_in_newer(const ExposedFrame& older, const ExposedFrame& newer) {
    return newer.exposure <= older.exposure;
  }
  // After the state took the frame in: its residuals become part of what samples of this exposure are worth.
  void take_over_residuals(const ExposedFrame& frame);

  // What the frame's codes mean. Valid until the next meet().
  const ExposureTables& tables_for(const ExposedFrame& frame);

  // --- what is known ---
  const Response& response() const { return response_; }
  // Of the codes that the camera itself writes, black removed and the range stretched again to 255: another
  // one where they are companded (capture/companding.h), or white is not the largest code.
  const Response& camera_response() const { return own_response_ ? *own_response_ : response_; }
  // False where no frames say anything about the response yet, and the mean of real cameras stands in.
  bool response_measured() const { return response_stated_ || learner_.measured(); }
  // Whether it is known well enough to judge exposures by: then ratios of pictures are as good as exact.
  bool response_is_sure() const {
    // One sigma of ln x. Frames that show the response leave .02 to .07; the mean of real cameras has .38.
    constexpr double kMostUncertain = 0.15;
    return response_stated_ || (learner_.measured() && learner_.uncertainty() < kMostUncertain);
  }
  // The frames, counted from 0, with which the response became another one.
  const std::vector<int>& relearned() const { return relearned_; }
  BlackLevel camera_black_level() const;  // in codes that the camera itself writes, as its white level
  const WhiteLevel& camera_white_level() const { return white_level_; }
  // Of the radiance that leaves (ResponseEstimate::neutral_gains).
  const std::optional<ChannelGains>& neutral_gains() const { return neutral_gains_; }
  const ExposureCorrections& exposures() const { return exposures_; }
  const NoiseModel& noise() const { return noise_; }  // at reference_gain()
  // False where no frames say anything about the noise yet, or are not asked: what was assumed stands in.
  bool noise_measured() const {
    return noise_.full_well != assumed_noise_.full_well || noise_.read_noise != assumed_noise_.read_noise;
  }
  NoiseOrigin noise_origin() const { return noise_origin_; }
  double reference_gain() const { return reference_gain_; }  // of the first frame
  // The share of the local contrast that the camera's own processing leaves as error (texture_error.h); where
  // its codes are a mosaic at least what interpolating that leaves.
  float texture_error() const { return texture_error_->share(); }
  float texture_error_of_mosaic() const { return texture_error_of_mosaic_; }  // 0: there is none
  // Whether frames show the motion blur that their exposure times state (shown_blur.h).
  bool blur_shown() const { return shown_blur_.shown(); }
  // Of the frames' own light where it is unsteady (frame_light.h), root mean square in stops; else 0.
  double light_spread_stops() const { return frame_light_.spread_stops(); }

 private:
  using ExposureAndGain = std::pair<float, float>;

  void go_over_to(const ResponseEstimate& estimate);
  float gain_of(const ExposedFrame& frame) const;
  bool looks_closely(const ExposedFrame& frame) const;
  // By all that is known now.
  ExposureTables tables_at(const ExposureAndGain& at) const;

  const NoiseKind noise_kind_;
  const BlurKind blur_kind_;
  const LightKind light_kind_;
  const bool response_stated_;
  const StateLayer& state_;
  WorkerPool& pool_;
  bool known_ = false;

  ResponseLearner learner_;
  Response response_;
  std::optional<Response> own_response_;  // the camera's, where it is another one
  BlackLevel black_level_;                // where white is 255
  WhiteLevel white_level_;
  std::optional<ChannelGains> neutral_gains_;
  ExposureCorrections exposures_;
  std::vector<float> first_light_;  // ln, of the first frames, where light is unsteady
  std::vector<int> relearned_;
  int begun_with_ = 0;  // the index of the first frame under this response

  NoiseOrigin noise_origin_ = NoiseOrigin::Unknown;
  NoiseModel assumed_noise_, noise_;  // before any measurement, and as measured so far
  std::optional<NoiseEstimator> noise_estimator_;
  const float texture_error_of_mosaic_;
  std::optional<TextureError> texture_error_;
  ShownBlur shown_blur_;
  FrameLight frame_light_;
  double reference_gain_ = 0;  // 0: no frame came yet
  std::map<ExposureAndGain, ExposureTables> tables_;
};

}  // namespace hdrcam
