// A point's radiance does not change from frame to frame: log radiance of the ray against the log radiance
// warped from the neighbour, weighted by the ray's occlusion weight. In the paper the codes of both frames
// enforce this indirectly; where the ray's own code is clipped they cannot, and this term carries the
// neighbour's radiance into the clipped frame. Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/losses/robust.h"

namespace hdrcam {

// radiance, warped radiance [3]. Adds to both gradients and to d_visible. Mean over channels.
template <class T>
T radiance_consistency_loss(T weight, T visible, const T* radiance, const T* warped, T* d_radiance,
                            T* d_warped, T& d_visible) {
  constexpr T kSoftness = T(0.05);
  T loss = 0;
  for (int c = 0; c < 3; ++c) {
    const auto rho = robust(std::log(radiance[c]) - std::log(warped[c]), kSoftness);
    loss += weight / 3 * rho.value;
    d_radiance[c] += visible * weight / 3 * rho.slope / radiance[c];
    d_warped[c] -= visible * weight / 3 * rho.slope / warped[c];
  }
  d_visible += loss;
  return visible * loss;
}

}  // namespace hdrcam
