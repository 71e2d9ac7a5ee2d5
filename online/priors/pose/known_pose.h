// The two pose sources that need no pictures: a camera that never moves, and poses that came with the frames.
// Thread-bound.
#pragma once

#include "hal/core/geometry.h"
#include "online/priors/pose/pose_prior.h"

namespace hdrcam {

class FixedPose final : public PosePrior {
 public:
  const CameraPose& estimate(const SeenFrame&) override { return pose_; }
  PoseSource source() const override { return PoseSource::Fixed; }

 private:
  CameraPose pose_;
};

// FrameFacts::T_world_camera relative to the first frame that has one. A frame without a finite pose keeps
// the last one and is flagged as lost.
class GivenPose final : public PosePrior {
 public:
  const CameraPose& next(const FrameFacts& facts);
  const CameraPose& estimate(const SeenFrame& seen) override { return next(seen.frame.facts); }
  PoseSource source() const override { return PoseSource::Given; }
  float near() const override { return 0.5f; }  // metres

 private:
  CameraPose pose_;
  RigidTransform T_first_world_;
  bool started_ = false;
};

}  // namespace hdrcam
