// Depth prior (paper appendix, L_depth) on rendered inverse depth. The paper normalises scale and shift per
// picture; here the prior must come aligned to the window's units, because a stream's scale must not change
// from frame to frame. Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/losses/robust.h"

namespace hdrcam {

template <class T>
T depth_loss(T weight, T inverse_depth, T prior, T& d_inverse_depth) {
  constexpr T kSoftness = T(0.01);
  const auto rho = robust(inverse_depth - prior, kSoftness);
  d_inverse_depth += weight * rho.slope;
  return weight * rho.value;
}

}  // namespace hdrcam
