// Distortion (Barron et al. 2022, mip-NeRF 360, eq. 15) in inverse depth: it makes the weights along a ray
// compact.
//   sum_{k,m} w_k w_m |q_k - q_m| + 1/3 sum_k w_k^2 delta_k
// Reentrant.
#pragma once

#include <cmath>

namespace hdrcam {

// Adds to d_ray_weight[count].
template <class T>
T distortion_loss(T weight, int count, const T* ray_weight, const T* inverse_depth, T* d_ray_weight) {
  T loss = 0;
  for (int k = 0; k < count; ++k) {
    T spread = 0;
    for (int m = 0; m < count; ++m) spread += ray_weight[m] * std::abs(inverse_depth[k] - inverse_depth[m]);
    const T width = k + 1 < count ? inverse_depth[k] - inverse_depth[k + 1] : T(0);
    loss += weight * ray_weight[k] * (spread + ray_weight[k] * width / 3);
    d_ray_weight[k] += weight * 2 * (spread + ray_weight[k] * width / 3);
  }
  return loss;
}

}  // namespace hdrcam
