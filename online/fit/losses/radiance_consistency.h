// What a point looks like does not change from frame to frame: log radiance of the ray against the log radiance warped
// from the neighbour. In the paper the codes of both frames do this indirectly; where the own code is clipped they
// cannot, and this term carries what a neighbour saw into the frame that did not. Reentrant.
#pragma once

#include "online/fit/losses/robust.h"

namespace hdrcam {

// radiance, warped radiance [3], relevance[3] 0..1 (1 unless both frames are blind). Adds to both gradients. Mean over
// channels.
template <class T>
T radiance_consistency_loss(T weight, const T* radiance, const T* warped, const T* relevance, T* d_radiance,
                            T* d_warped) {
  constexpr T kSoftness = T(0.05);
  T loss = 0;
  for (int c = 0; c < 3; ++c) {
    const auto rho = robust(std::log(radiance[c]) - std::log(warped[c]), kSoftness);
    const T scale = weight / 3 * relevance[c];
    loss += scale * rho.value;
    d_radiance[c] += scale * rho.slope / radiance[c];
    d_warped[c] -= scale * rho.slope / warped[c];
  }
  return loss;
}

}  // namespace hdrcam
