// A soft threshold. Reentrant.
#pragma once

#include <algorithm>

namespace hdrcam {

// 0 up to `begin`, 1 from `end` on, a smooth cubic between.
inline float smooth_step(float begin, float end, float x) {
  const float t = std::clamp((x - begin) / (end - begin), 0.f, 1.f);
  return t * t * (3 - 2 * t);
}

}  // namespace hdrcam
