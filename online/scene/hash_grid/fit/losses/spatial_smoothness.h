// Spatial smoothness of scene flow (paper appendix, L_sp): neighbouring samples a, b of one ray move alike.
// Their distance d in window units weights by exp(-2 d); flow in pixels of the anchor. Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/losses/robust.h"

namespace hdrcam {

template <class T>
T spatial_smoothness_loss(T weight, T distance, const T* flow_a, const T* flow_b, T* d_a, T* d_b) {
  const T near = weight * std::exp(-2 * distance);
  constexpr T kSoftness_px = T(0.1);
  T loss = 0;
  for (int a = 0; a < 3; ++a) {
    const auto rho = robust(flow_a[a] - flow_b[a], kSoftness_px);
    loss += near * rho.value;
    d_a[a] += near * rho.slope;
    d_b[a] -= near * rho.slope;
  }
  return loss;
}

}  // namespace hdrcam
