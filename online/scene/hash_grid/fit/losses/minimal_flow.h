// Minimal flow (paper appendix, L_min): |f|, here on the residual, because the base carries the measured
// motion and the network should add little; with an empty base it equals the paper's. Flow in pixels of the
// anchor. Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/losses/robust.h"

namespace hdrcam {

template <class T>
T minimal_flow_loss(T weight, const T* residual, T* d_residual) {
  constexpr T kSoftness_px = T(0.1);
  T loss = 0;
  for (int a = 0; a < 3; ++a) {
    const auto rho = robust(residual[a], kSoftness_px);
    loss += weight * rho.value;
    d_residual[a] += weight * rho.slope;
  }
  return loss;
}

}  // namespace hdrcam
