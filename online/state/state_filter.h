// The state: a picture of radiance with its variance that is carried along the motion and updated by each
// frame with the right noise model, a robust Kalman filter per pixel in radiance (docs/architecture.md, "two
// layers"). Causal: it uses frames up to the newest one only. Thread-bound.
#pragma once

#include "capture/exposed_frame.h"
#include "online/state/fusion.h"
#include "online/state/sample_residuals.h"

namespace hdrcam {

struct StateOptions {
  FusionOptions fusion;
  float variance_growth = 0.05f;  // per frame: rate at which the past is forgotten
  float relative_growth = 0.01f;  // of radiance per frame: changing light
};

// A frame as the state takes it. Its index stands for its codes: from one restart() to the next they are the
// same whenever the frame comes, also as a later one.
struct StateInput {
  const ExposedFrame& frame;
  const ExposureTables& tables;  // at its exposure
  float unseen_variance;         // from which on a pixel of the state counts as unseen
  bool blurs = true;             // motion during the exposure counts

  float blur_fraction() const { return blurs ? frame.blur_fraction : 0; }
};

class StateFilter {
 public:
  StateFilter(StateOptions options, int rows, int cols, WorkerPool& pool);

  // Starts with the first frame of a clip or of a new scene and discards the state.
  void restart(const StateInput& input);

  // What residuals told is of another response: before the tables of the next frame are made.
  void forget_residuals() { residuals_ = SampleResiduals(); }

  // Goes on from what somebody else knows of a clip.
  void resume(const RadianceState& state, const SampleResiduals& residuals) {
    state_.copy_from(state);
    residuals_ = residuals;
  }

  // Carries the state from the previous frame to this one along `to_previous` (this frame -> the previous
  // one) and updates it with this frame's samples.
  void advance(const StateInput& input, const FlowField& to_previous);

  const RadianceState& state() const { return state_; }
  const SampleResiduals& residuals() const { return residuals_; }
  Fusion& fusion() { return fusion_; }

 private:
  // Carries the state to the frame of samples_.
  void predict(const StateInput& input, const FlowField& to_previous);

  StateOptions options_;
  WorkerPool& pool_;
  Fusion fusion_;
  RadianceState state_;
  SampleResiduals residuals_;
  RadianceEstimate predicted_;  // this and the following are borrowed during a call
  Samples samples_;
  Image<float> gate_, contrast_;
  Image<float> per_contrast_;  // lines
};

}  // namespace hdrcam
