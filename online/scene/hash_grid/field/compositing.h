// Volume rendering along one ray (paper eq. "nsff_combine_static"): samples near to far, each with a static
// and a dynamic density. The rendered value of any quantity is sum_k w_k ((1 - s_k) static_k + s_k
// dynamic_k), with
//   alpha_k = 1 - exp(-(sigma_s + sigma_d) delta),   w_k = alpha_k prod_{m<k} (1 - alpha_m),
//   s_k = sigma_d / (sigma_s + sigma_d)
// The last sample is opaque, so every ray ends on a surface and the weights sum to 1.
// Reentrant.
#pragma once

#include <cmath>

#include "online/scene/hash_grid/field/ray_constants.h"

namespace hdrcam {

using ray_constants::kMaxSamples;
template <class T>
inline constexpr T kEmptyDensity = T(ray_constants::kEmptyDensity);

template <class T>
struct Composite {
  int count = 0;
  T density[2][kMaxSamples];                          // static, dynamic, per unit of spacing
  T weight[kMaxSamples];                              // w
  T share[kMaxSamples];                               // s
  T transmittance[kMaxSamples], passed[kMaxSamples];  // before the sample; 1 - alpha of the sample
};

template <class T>
void composite_ray(const T* spacing, Composite<T>& ray) {
  T light = 1;
  for (int k = 0; k < ray.count; ++k) {
    const T total = ray.density[0][k] + ray.density[1][k] + kEmptyDensity<T>;
    ray.share[k] = ray.density[1][k] / total;
    ray.passed[k] = k + 1 < ray.count ? std::exp(-total * spacing[k]) : T(0);
    ray.transmittance[k] = light;
    ray.weight[k] = light * (1 - ray.passed[k]);
    light *= ray.passed[k];
  }
}

// d_density[2][count] from the gradients with respect to weights and shares.
template <class T>
void composite_backward(const T* spacing, const Composite<T>& ray, const T* d_weight, const T* d_share,
                        T (*d_density)[kMaxSamples]) {
  T behind = 0;  // sum over the samples behind k of w d_weight
  for (int k = ray.count - 1; k >= 0; --k) {
    const T total = ray.density[0][k] + ray.density[1][k] + kEmptyDensity<T>;
    const T d_total =
        k + 1 < ray.count ? spacing[k] * (ray.transmittance[k] * ray.passed[k] * d_weight[k] - behind) : T(0);
    behind += ray.weight[k] * d_weight[k];
    d_density[0][k] = d_total - d_share[k] * ray.share[k] / total;
    d_density[1][k] = d_total + d_share[k] * (1 - ray.share[k]) / total;
  }
}

}  // namespace hdrcam
