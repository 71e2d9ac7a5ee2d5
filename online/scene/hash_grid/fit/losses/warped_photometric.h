// Warped photometric loss (paper eq. "hdr_nsff_photometric_loss"): the picture of frame i rendered from
// neighbour j's dynamic branch at the points displaced by the scene flow, compared to frame i's codes with
// frame i's exposure. It is weighted by the rendered occlusion weight (occlusion.h). Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/losses/photometric.h"

namespace hdrcam {

// visible: the ray's occlusion weight 0..1. Adds to d_radiance[3] (of the warped picture) and d_visible.
template <class T>
T warped_photometric_loss(T weight, const LearnedResponse<T>& response, T exposure, const T* warped_radiance,
                          const float* measured, T visible, T* d_radiance, T& d_visible) {
  T d_unweighted[3] = {0, 0, 0};
  const T loss = photometric_loss(weight, response, exposure, warped_radiance, measured, d_unweighted,
                                  static_cast<typename LearnedResponse<T>::Gradient*>(nullptr));
  for (int c = 0; c < 3; ++c) d_radiance[c] += visible * d_unweighted[c];
  d_visible += loss;
  return visible * loss;
}

}  // namespace hdrcam
