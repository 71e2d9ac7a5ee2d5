// Entropy of the blend: a ray should be static or dynamic, not half of each. share: rendered dynamic share
// 0..1, clamped inside the ends, where the slope is infinite. Reentrant.
#pragma once

#include <algorithm>
#include <cmath>

namespace hdrcam {

template <class T>
T blend_entropy_loss(T weight, T share, T& d_share) {
  constexpr T kEnd = T(1e-3);
  const T s = std::clamp(share, kEnd, 1 - kEnd);
  if (s == share) d_share += weight * (std::log(1 - s) - std::log(s));
  return -weight * (s * std::log(s) + (1 - s) * std::log(1 - s));
}

}  // namespace hdrcam
