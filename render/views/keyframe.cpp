#include "render/views/keyframe.h"

#include <Eigen/Geometry>

namespace hdrcam {

void take_keyframe(const HdrFrame& frame, const FrameEstimate& estimate, Keyframe& key) {
  copy_picture(frame, key.frame);
  if (estimate.to_previous != nullptr)
    key.frame.flow.copy_from(estimate.to_previous->vectors);
  else
    key.frame.flow.reshape(0, 0, 0);
  for (FlowField* flow : {&key.to_previous, &key.from_previous})
    flow->vectors.reshape(0, 0, 0), flow->confidence.reshape(0, 0, 0);
  key.time_s = estimate.view.time_s;
  key.T_world_camera = estimate.view.T_world_camera;
  key.world = estimate.world;
  key.lens = estimate.view.lens;
  key.depth_unit = estimate.depth_unit;
  key.inverse_depth.reshape(0, 0, 0);
  key.knows_depth = estimate.depth != nullptr && estimate.depth->tells();
}

RigidTransform between(const RigidTransform& T_world_a, const RigidTransform& T_world_b, double share) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(T_world_a.R.transpose() * T_world_b.R));
  return {T_world_a.R * rotation(turn.axis() * (turn.angle() * share)),
          T_world_a.t + share * (T_world_b.t - T_world_a.t)};
}

}  // namespace hdrcam
