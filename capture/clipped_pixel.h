// Whether a pixel is clipped in all its channels, for one of the uses that clip_policy.h names. Not there:
// kernels include those limits, and may include no inline code (CMakeLists.txt). Reentrant.
#pragma once

#include <algorithm>

#include "capture/clip_policy.h"

namespace hdrcam::clip_policy {

// All of its channels bright, or all of them dark.
inline bool all_clipped(float r, float g, float b, const UsableCodes& usable) {
  const float least = std::min(std::min(r, g), b), most = std::max(std::max(r, g), b);
  return least >= usable.brightest || most <= usable.darkest;
}

}  // namespace hdrcam::clip_policy
