// Photometric loss in the LDR domain (paper eq. "hdr_nsff_cb_photometric_loss"): |g(E L) - C|, E known. A
// clipped code is a bound: a prediction beyond it costs nothing. The same function serves the combined
// picture (L_cb) and the picture warped from a neighbour (L_photo, eq. "hdr_nsff_photometric_loss").
// Reentrant.
#pragma once

#include "capture/clip_policy.h"
#include "online/scene/hash_grid/field/window.h"
#include "online/scene/hash_grid/fit/learned_response.h"
#include "online/scene/hash_grid/fit/losses/robust.h"

namespace hdrcam {

// radiance[3], measured values[3] (kNoValue: none). Adds to d_radiance[3] and, if not null, to the response's
// gradient. Returns the weighted loss, mean over channels.
template <class T>
T photometric_loss(T weight, const LearnedResponse<T>& response, T exposure, const T* radiance,
                   const float* measured, T* d_radiance, typename LearnedResponse<T>::Gradient* d_response) {
  using clip_policy::kLossOfOne;
  constexpr T kSoftness = T(0.01);
  T loss = 0;
  for (int c = 0; c < 3; ++c) {
    if (measured[c] == kNoValue) continue;
    const auto predicted = response.evaluate(c, exposure * radiance[c]);
    const T error = predicted.value - T(measured[c]);
    if ((measured[c] >= kLossOfOne.brightest && error > 0) ||
        (measured[c] <= kLossOfOne.darkest && error < 0))
      continue;
    const auto rho = robust(error, kSoftness);
    const T d_value = weight / 3 * rho.slope;
    loss += weight / 3 * rho.value;
    d_radiance[c] += d_value * predicted.d_log / radiance[c];
    if (d_response != nullptr) LearnedResponse<T>::accumulate(c, predicted, d_value, *d_response);
  }
  return loss;
}

}  // namespace hdrcam
