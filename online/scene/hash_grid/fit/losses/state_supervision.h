// Supervision by the state: rendered log radiance against the state's, weighted by the state's certainty.
// Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/losses/robust.h"

namespace hdrcam {

// radiance[3], state log radiance[3], trust[3] 0..1 (1 - gate). Adds to d_radiance[3]. Mean over channels.
template <class T>
T state_loss(T weight, const T* radiance, const T* state_log_radiance, const T* trust, T* d_radiance) {
  constexpr T kSoftness = T(0.05);
  T loss = 0;
  for (int c = 0; c < 3; ++c) {
    const auto rho = robust(std::log(radiance[c]) - state_log_radiance[c], kSoftness);
    loss += weight / 3 * trust[c] * rho.value;
    d_radiance[c] += weight / 3 * trust[c] * rho.slope / radiance[c];
  }
  return loss;
}

}  // namespace hdrcam
