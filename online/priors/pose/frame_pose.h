// Where a frame was seen from and how that is known, as outputs state it. The world is the recording's where
// poses are given, else the camera of the first frame; camera axes x right, y down, z forward. Plain values,
// reentrant.
#pragma once

#include "hal/core/geometry.h"

namespace hdrcam {

enum class PoseSource {
  Given,    // stated in the recording
  Tracked,  // from the optical flow
  Fixed,    // assumed: a tripod
};

constexpr const char* name(PoseSource source) {
  switch (source) {
    case PoseSource::Given:
      return "given";
    case PoseSource::Tracked:
      return "tracked";
    case PoseSource::Fixed:
      return "fixed";
  }
  return "unknown";
}

// The unit of length of poses and depth.
enum class LengthUnit {
  Metre,       // of given poses
  FirstDepth,  // of tracked ones, whose scale one camera cannot see: the median depth of the first view
  Unknown,     // a camera that is assumed to stand still shows no length
};

constexpr const char* name(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::Metre:
      return "metre";
    case LengthUnit::FirstDepth:
      return "median depth of the first view";
    case LengthUnit::Unknown:
      return "unknown";
  }
  return "unknown";
}

constexpr LengthUnit unit_of(PoseSource source) {
  switch (source) {
    case PoseSource::Given:
      return LengthUnit::Metre;
    case PoseSource::Tracked:
      return LengthUnit::FirstDepth;
    case PoseSource::Fixed:
      return LengthUnit::Unknown;
  }
  return LengthUnit::Unknown;
}

struct FramePose {
  RigidTransform T_world_camera;
  PoseSource source = PoseSource::Given;
  bool lost = false;  // of a tracked one: it only continues the previous motion
  int world = 0;      // tracking that began anew has another world: their poses do not belong together
};

}  // namespace hdrcam
