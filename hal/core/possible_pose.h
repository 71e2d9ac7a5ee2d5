// Whether a transform that was read can be the pose of a camera (sound_facts.h has the limits). Reentrant.
#pragma once

#include "hal/core/geometry.h"
#include "hal/core/sound_facts.h"

namespace hdrcam {

inline bool is_possible_pose(const RigidTransform& T_world_camera) {
  return !objection_to(pose_matrix_of(T_world_camera));
}

}  // namespace hdrcam
