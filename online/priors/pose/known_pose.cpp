#include "online/priors/pose/known_pose.h"

namespace hdrcam {
namespace {

// Below this a given pose has not changed: an angle in radians, a length in metres.
constexpr double kSame = 1e-6;

CameraMotion motion_between(const RigidTransform& before, const RigidTransform& after) {
  if ((before.t - after.t).norm() > kSame) return CameraMotion::General;
  return (before.R - after.R).norm() > kSame ? CameraMotion::Rotation : CameraMotion::Static;
}

}  // namespace

const CameraPose& GivenPose::next(const FrameFacts& facts) {
  const RigidTransform given = facts.T_world_camera ? transform_of(*facts.T_world_camera) : RigidTransform{};
  pose_.lost = !facts.T_world_camera || !given.finite();
  pose_.motion = CameraMotion::Static;
  if (pose_.lost) return pose_;
  if (!started_) T_first_world_ = given.inverse(), started_ = true;
  const RigidTransform T_first_camera = T_first_world_ * given;
  pose_.motion = motion_between(pose_.T_world_camera, T_first_camera);
  pose_.T_world_camera = T_first_camera;
  return pose_;
}

}  // namespace hdrcam
