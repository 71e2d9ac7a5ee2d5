// The camera's pose per frame: the interface for pose estimation, which gets the frame and the state. Three
// implementations. Fixed: a tripod. Given: from the frame's facts. Tracked: from the optical flow alone. The
// world is the camera of the first frame, so the first pose is always the identity. Unit of length: metres
// where poses are given, the median depth of the first view where they are tracked (the scale of a single
// camera is not observable). A pose is never NaN; a frame without a usable pose is flagged as lost and
// continues the previous motion (tracked) or stays where it was (given). Thread-bound: one thread owns a
// prior.
#pragma once

#include <memory>

#include "hal/core/frame.h"
#include "hal/core/geometry.h"
#include "hal/core/worker_pool.h"
#include "online/priors/pose/frame_pose.h"
#include "online/priors/seen_frame.h"

namespace hdrcam {

struct CameraPose {
  RigidTransform T_world_camera;
  bool lost = false;  // the pose only continues what was before
};

class PosePrior {
 public:
  virtual ~PosePrior() = default;
  // Estimates the pose of the next frame; the result belongs to the prior until the next call.
  virtual const CameraPose& estimate(const SeenFrame& seen) = 0;
  virtual PoseSource source() const = 0;
  // Distance of the near plane, in the poses' unit of length.
  virtual float near() const { return 0.25f; }
};

enum class PoseKind {
  Given,    // from the recording; tracked where it has none
  Tracked,  // from the optical flow, even where the recording has poses
  Fixed,    // a tripod
};

// The lens assumed for an unreported one: 55 degrees across, square pixels, centred.
Intrinsics assumed_intrinsics(int rows, int cols);

// has_poses: the frames carry T_world_camera. pool: of the thread that owns the prior. A tracked prior
// assumes the lens above for a missing one.
std::unique_ptr<PosePrior> make_pose_prior(PoseKind kind, const CameraFacts& camera, bool has_poses,
                                           WorkerPool& pool);
// Logs that it does.
void warn_of_assumed_lens(const CameraFacts& camera);

}  // namespace hdrcam
