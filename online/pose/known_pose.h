// The two poses that need no pictures: a camera that never moves, and one whose poses came with the frames.
#pragma once

#include "online/pose/pose_source.h"
#include "online/pose/rigid_transform.h"

namespace hdrcam {

class FixedPose final : public PoseSource {
 public:
  const CameraPose& next(const FrameFacts&, const FlowField&, const FlowField&) override { return pose_; }

 private:
  CameraPose pose_;
};

// FrameFacts::T_world_camera relative to the first frame that has one. A frame without a finite pose keeps
// the last one and is flagged as lost.
class GivenPose final : public PoseSource {
 public:
  const CameraPose& next(const FrameFacts& facts, const FlowField& to_previous,
                         const FlowField& from_previous) override;

 private:
  CameraPose pose_;
  RigidTransform T_first_world_;
  bool started_ = false;
};

}  // namespace hdrcam
