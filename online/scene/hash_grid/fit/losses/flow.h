// Flow loss (paper appendix, L_flow): the distance in neighbour j between the pixel that the scene flow gives
// for a ray and the pixel that the flow prior gives, in pixels. The paper projects the rendered mean of the
// displaced points; here each sample's landing is projected, and the pixels are averaged with the weights of
// rendering (ray_rendering.h): the same where one surface has all the weight. Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/losses/robust.h"

namespace hdrcam {

// predicted, prior: pixel[2] in the neighbour. Adds to d_predicted[2].
template <class T>
T flow_loss(T weight, const T* predicted, const T* prior, T* d_predicted) {
  constexpr T kSoftness_px = T(0.1);
  T loss = 0;
  for (int a = 0; a < 2; ++a) {
    const auto rho = robust(predicted[a] - prior[a], kSoftness_px);
    loss += weight * rho.value;
    d_predicted[a] += weight * rho.slope;
  }
  return loss;
}

}  // namespace hdrcam
