// The two neighbouring keyframes around a time, and where it lies between them. Borrows them; reentrant.
#pragma once

#include "hal/core/check.h"
#include "render/views/keyframe.h"

namespace hdrcam {

// share 0 is `before`, 1 is `after`. One of them may be null where there is no such frame in the other's
// world; the share is then 1 or 0.
struct KeyframeInterval {
  const Keyframe* before = nullptr;
  const Keyframe* after = nullptr;
  double share = 0;

  // The keyframe nearer in time.
  const Keyframe& nearest() const {
    const Keyframe* key = after == nullptr || (before != nullptr && share < 0.5) ? before : after;
    HDRCAM_CHECK(key != nullptr);
    return *key;
  }
  // Neither is at the moment itself.
  bool lies_between() const { return before != nullptr && after != nullptr && share > 0 && share < 1; }
  double time_s() const;
  // The recorded camera at this time.
  RigidTransform T_world_camera() const;
};

}  // namespace hdrcam
