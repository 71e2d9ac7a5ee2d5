#include "online/priors/pose/known_pose.h"

namespace hdrcam {

const CameraPose& GivenPose::next(const FrameFacts& facts) {
  const RigidTransform given = facts.T_world_camera ? transform_of(*facts.T_world_camera) : RigidTransform{};
  pose_.lost = !facts.T_world_camera || !given.finite();
  if (pose_.lost) return pose_;
  if (!started_) T_first_world_ = given.inverse(), started_ = true;
  pose_.T_world_camera = T_first_world_ * given;
  return pose_;
}

}  // namespace hdrcam
