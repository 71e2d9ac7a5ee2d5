// An emitted frame as a source of other views: its picture, the depth of each pixel, the motion to its
// neighbours and its camera. Depth and poses share one unit of length: metres where poses are given, else the
// median depth of the first view. Move-only value; reshaping one that is reused allocates nothing.
#pragma once

#include "hal/core/frame.h"
#include "hal/core/geometry.h"
#include "online/frame_estimate.h"
#include "render/hdr_frame.h"

namespace hdrcam {

struct Keyframe {
  HdrFrame frame;
  double time_s = 0;  // centre of the exposure
  RigidTransform T_world_camera;
  int world = 0;  // FrameEstimate::world, of pose and depth
  Intrinsics lens;
  Image<float> inverse_depth;  // [1, rows, cols] 1 / camera z, > 0
  bool knows_depth = true;  // of anything; else the inverse depth is the same everywhere, 1 without a field
  float depth_unit = 1;     // of the depth of the field that fills holes, in that unit of length
  FlowField to_previous;    // to the keyframe before; empty at the first
  FlowField from_previous;  // from the keyframe before to this one; empty at the first
};

// frame: as emitted for the estimate. Copies it with its camera, notes whether any depth is known, and leaves
// depth and motion empty (keyframe_maker.h).
void take_keyframe(const HdrFrame& frame, const FrameEstimate& estimate, Keyframe& key);

// The camera between two keyframes, 0 at a and 1 at b; outside, the motion goes on.
RigidTransform between(const RigidTransform& T_world_a, const RigidTransform& T_world_b, double share);

}  // namespace hdrcam
