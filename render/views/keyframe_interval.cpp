#include "render/views/keyframe_interval.h"

namespace hdrcam {

double KeyframeInterval::time_s() const {
  if (after == nullptr) return before->time_s;
  if (before == nullptr) return after->time_s;
  return before->time_s + share * (after->time_s - before->time_s);
}

RigidTransform KeyframeInterval::T_world_camera() const {
  if (after == nullptr) return before->T_world_camera;
  if (before == nullptr) return after->T_world_camera;
  return between(before->T_world_camera, after->T_world_camera, share);
}

}  // namespace hdrcam
