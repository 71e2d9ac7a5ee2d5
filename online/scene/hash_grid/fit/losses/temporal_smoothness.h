// Temporal smoothness of scene flow (paper appendix, L_temp): 1/2 |f_{i->i+1} + f_{i->i-1}|^2, uniform
// motion. The square becomes linear beyond four pixels (Huber), because a wrong prior must not dominate a
// step. Reentrant.
#pragma once

#include <cmath>

namespace hdrcam {

template <class T>
T temporal_smoothness_loss(T weight, const T* forward, const T* backward, T* d_forward, T* d_backward) {
  constexpr T kLinearBeyond_px = 4;
  T loss = 0;
  for (int a = 0; a < 3; ++a) {
    const T change = forward[a] + backward[a], size = std::abs(change);
    const bool square = size <= kLinearBeyond_px;
    loss += weight * (square ? T(0.5) * size * size : kLinearBeyond_px * (size - T(0.5) * kLinearBeyond_px));
    const T slope = weight * (square ? change : std::copysign(kLinearBeyond_px, change));
    d_forward[a] += slope;
    d_backward[a] += slope;
  }
  return loss;
}

}  // namespace hdrcam
