// Where the camera is, per frame: one small interface, three answers. Fixed: a tripod. Given: from the
// frame's facts. Tracked: from the optical flow alone. The world is the camera of the first frame, so the
// first pose is always the identity. Unit of length: metres where poses are given, the median depth of the
// first view where they are tracked (the scale of a single camera is not observable). A pose is never NaN; a
// frame whose pose could not be found is flagged as lost and continues the motion before it. Thread-bound:
// one thread owns a source; what next() returns belongs to the source until the next call.
#pragma once

#include <memory>
#include <vector>

#include "hal/core/frame.h"
#include "online/motion/flow_field.h"

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
  PoseMatrix T_world_camera{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  CameraMotion motion = CameraMotion::Still;
  float inlier_share = 1;                  // share of the tracked points that agree with the pose, 0..1
  bool lost = false;                       // the pose is a guess: the motion before, continued
  std::vector<DepthSample> depth_samples;  // empty unless tracked
};

class PoseSource {
 public:
  virtual ~PoseSource() = default;
  // The pose of the next frame. to_previous: this frame -> the one before; from_previous: the other way
  // round, both [dx dy, rows, cols] px; empty for the first frame.
  virtual const CameraPose& next(const FrameFacts& facts, const FlowField& to_previous,
                                 const FlowField& from_previous) = 0;
};

enum class PoseKind { Fixed, Given, Tracked };

// The lens of a camera that does not say: 55 degrees across, square pixels, centred.
Intrinsics assumed_intrinsics(int rows, int cols);

// A missing lens is assumed (above) and said so in the log.
std::unique_ptr<PoseSource> make_pose_source(PoseKind kind, const CameraFacts& camera);

}  // namespace hdrcam
