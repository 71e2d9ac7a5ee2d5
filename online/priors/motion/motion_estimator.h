// Estimates motion between a new frame and the state. The state is re-exposed at the frame's exposure, so
// that both pictures look alike for any schedule, and matched in both directions. Where the frame is clipped
// it shows no motion; there the predicted motion goes on, or the motion is taken from the frame after it, if
// that one is not clipped too. Both follow a motion that changes. Thread-bound.
#pragma once

#include "online/priors/motion/bridge_error.h"
#include "online/priors/motion/camera_shake.h"
#include "online/priors/motion/dense_flow.h"
#include "online/priors/motion/landing.h"
#include "online/priors/motion/motion_prior.h"

namespace hdrcam {

class MotionEstimator final : public MotionPrior {
 public:
  MotionEstimator(int rows, int cols, WorkerPool& pool, GpuDevice* gpu = nullptr);

  // Matches both flows. The state is rendered as the frame would show it: at its exposure, and blurred along
  // the predicted motion. The search starts from that motion.
  void match(const RadianceState& state, const ExposedFrame& frame, const ExposureTables& tables,
             const MatchContext& context, const RatedFlows& rated, StateMotion& motion) override;
  // Completes the motion where the frame is clipped, from the predicted motion and from the next frame.
  void complete(const RadianceState& state, const ExposedFrame& frame, const MotionContext& context,
                FlowQuality quality, const RatedFlows& rated, StateMotion& motion) override;
  std::string fallback_reason() const override { return flow_->fallback_reason(); }

 private:
  void shake_prediction(float ratio);
  void start_at_prediction(float ratio, FlowRequest& request) const;
  void continue_predicted(float ratio, Image<float>& to);
  template <class After>
  bool is_worth_bridging(After&& after) const;
  void match_after(const RadianceState& state, const MotionContext& context, FlowQuality quality);
  void bridge(const MotionContext& context, StateMotion& motion);
  void predict(float ratio, const Image<float>& motion);
  void clipped_share(const ExposedFrame& frame, Image<float>& share);

  int rows_, cols_;
  WorkerPool& pool_;
  std::unique_ptr<DenseFlow> flow_;
  CameraShake shake_;
  Image<float> last_;  // the completed motion of the last step: from the state's pixels to the previous state
  Image<float> measured_;         // [1, rows, cols] 0..1: how much of that was measured, and how lately
  Image<float> measured_before_;  // the same of the step before it
  Image<float> predicted_;        // the motion of the next step, if it takes as long as the last one
  BridgeError bridge_error_;
  Landing landing_;  // what is fast from the state to the frame after a clipped one, in the clipped one
  // All others are borrowed during a call.
  Image<float> frame_gray_, state_gray_, blur_;  // codes; the blur that the frame's exposure adds
  Image<float> mask_, clipped_, clipped_after_, after_to_state_, state_to_after_;
};

}  // namespace hdrcam
