// Where the camera is, per frame: the seam for another way to know it, fed with the frame and the state.
// Three answers. Fixed: a tripod. Given: from the frame's facts. Tracked: from the optical flow alone. The
// world is the camera of the first frame, so the first pose is always the identity. Unit of length: metres
// where poses are given, the median depth of the first view where they are tracked (the scale of a single
// camera is not observable). A pose is never NaN; a frame whose pose could not be found is flagged as lost
// and continues the motion before it. Thread-bound: one thread owns a prior.
#pragma once

#include <memory>
#include <vector>

#include "hal/core/frame.h"
#include "hal/core/geometry.h"
#include "online/priors/seen_frame.h"

namespace hdrcam {

// What the camera did since the previous frame. Still and Rotation are exact: the pose or its translation is
// kept.
enum class CameraMotion { Still, Rotation, General };
const char* name(CameraMotion motion);

// A tracked point of the scene as seen by this frame.
struct DepthSample {
  float u_px = 0, v_px = 0;  // pixel centres at +0.5
  float inverse_depth = 0;   // 1 / camera z, in 1 / unit of length, >= 0
  float weight = 0;          // d^2 / (d^2 + sigma_d^2): 1 known, 0.5 known to 100 percent, 0 unknown
};

struct CameraPose {
  RigidTransform T_world_camera;
  CameraMotion motion = CameraMotion::Still;
  float inlier_share = 1;                  // share of the tracked points that agree with the pose, 0..1
  bool lost = false;                       // the pose is a guess: the motion before, continued
  std::vector<DepthSample> depth_samples;  // empty unless tracked
};

class PosePrior {
 public:
  virtual ~PosePrior() = default;
  // The pose of the next frame; it belongs to the prior until the next call.
  virtual const CameraPose& estimate(const SeenFrame& seen) = 0;
  // Where what is near the camera begins, in the poses' unit of length.
  virtual float near() const { return 0.25f; }
};

enum class PoseKind {
  Given,    // of the recording; tracked where it has none
  Tracked,  // from the optical flow, whatever the recording says
  Fixed,    // a tripod
};

// The lens of a camera that does not say: 55 degrees across, square pixels, centred.
Intrinsics assumed_intrinsics(int rows, int cols);

// has_poses: the frames carry T_world_camera. A missing lens is assumed (above) and said so in the log.
std::unique_ptr<PosePrior> make_pose_prior(PoseKind kind, const CameraFacts& camera, bool has_poses);

}  // namespace hdrcam
