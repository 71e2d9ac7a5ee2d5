// Decodes the raw outputs of the two networks at one sample, given the base there; each decode function has
// its gradient. Scalar type T as in hash_grid.h. Reentrant.
#pragma once

#include <algorithm>
#include <cmath>

#include "online/scene/hash_grid/field/field.h"

namespace hdrcam {

// One decoded sample. The same struct holds the gradient with respect to each member.
template <class T>
struct FieldSample {
  T density = 0;
  T radiance[3] = {0, 0, 0};
  T blend = 0;                 // v, of the static branch
  T flow[2][3] = {};           // by Neighbour: pixels of the anchor along u and v, kDepthUnit along d
  T flow_residual[2][3] = {};  // the network's residual to the base
  T occlusion[2] = {0, 0};     // 1: the point is visible in that neighbour too
};

// The exponent of densities and radiances is clamped where floats would overflow.
template <class T>
T bounded_exp(T x, T bound) {
  return std::exp(std::clamp(x, -bound, bound));
}
template <class T>
T sigmoid(T x) {
  return 1 / (1 + std::exp(-x));
}
using ray_constants::kDensityBound;
using ray_constants::kRadianceBound;

// The prior of log density for both branches: the base's surface, with empty space in front of it.
// log_density at an inverse depth, and its slopes by inverse depth and by the surface's inverse depth.
template <class T>
struct SurfacePrior {
  T log_density, by_depth, by_surface;
};
template <class T>
SurfacePrior<T> surface_prior(T inverse_depth, T surface) {
  using namespace ray_constants;
  constexpr T kPerDepth = T(kThicknessPerDepth);
  const T width = T(kThickness) + kPerDepth * surface, away = (inverse_depth - surface) / width;
  const T peak = T(kSurface) * std::exp(T(-0.5) * away * away), slope = peak * away / width;
  return {T(kEmptySpace) + peak, -slope, slope * (1 + away * kPerDepth)};
}

template <class T>
void decode_density(const Image<T>& raw, int s, T prior, FieldSample<T>& sample) {
  sample.density = bounded_exp(raw.plane(0)[s] + prior, T(kDensityBound));
}

template <class T>
void decode_radiance(const Image<T>& raw, int s, const T* base, FieldSample<T>& sample) {
  for (int c = 0; c < 3; ++c)
    sample.radiance[c] = bounded_exp(base[kBaseLogRadiance + c] + base[kBaseGate + c] * raw.plane(1 + c)[s],
                                     T(kRadianceBound));
}

// The prior of the static density: a base that moves is not static. Flow in pixels of the window.
template <class T>
T static_prior(const T* base) {
  using namespace ray_constants;
  T fastest = 0;
  for (int i = kBaseFlow; i < kBaseFlow + 4; ++i) fastest = std::max(fastest, std::abs(base[i]));
  return std::exp(-std::clamp(T(kPerPixel) * (fastest - T(kStill)), T(0), T(kLeastStatic)));
}

template <class T>
FieldSample<T> decode_static(const Image<T>& raw, int s, const T* base, T prior) {
  FieldSample<T> sample;
  decode_density(raw, s, prior, sample);
  decode_radiance(raw, s, base, sample);
  sample.density *= static_prior(base);
  sample.blend = sigmoid(raw.plane(StaticHead::kBlend)[s]);
  return sample;
}

template <class T>
FieldSample<T> decode_dynamic(const Image<T>& raw, int s, const T* base, T prior) {
  FieldSample<T> sample;
  decode_density(raw, s, prior, sample);
  decode_radiance(raw, s, base, sample);
  for (int k = 0; k < 2; ++k) {
    for (int a = 0; a < 3; ++a) {
      sample.flow_residual[k][a] = raw.plane(DynamicHead::kFlow + 3 * k + a)[s];
      sample.flow[k][a] = sample.flow_residual[k][a] + (a < 2 ? base[kBaseFlow + 2 * k + a] : T(0));
    }
    sample.occlusion[k] = sigmoid(raw.plane(DynamicHead::kOcclusion + k)[s]);
  }
  return sample;
}

// The gradient of decode_density; returns d_prior.
template <class T>
T decode_density_backward(const Image<T>& raw, int s, T prior, const FieldSample<T>& sample,
                          const FieldSample<T>& d, Image<T>& d_raw) {
  if (std::abs(raw.plane(0)[s] + prior) >= T(kDensityBound)) return 0;
  const T d_log = d.density * sample.density;
  d_raw.plane(0)[s] += d_log;
  return d_log;
}

// The gradient of decode_radiance; d_base, where the position is learned, receives the base's share.
template <class T>
void decode_radiance_backward(const Image<T>& raw, int s, const T* base, const FieldSample<T>& sample,
                              const FieldSample<T>& d, Image<T>& d_raw, T* d_base) {
  for (int c = 0; c < 3; ++c) {
    const T residual = raw.plane(1 + c)[s], gate = base[kBaseGate + c];
    if (std::abs(base[kBaseLogRadiance + c] + gate * residual) >= T(kRadianceBound)) continue;
    const T d_log = d.radiance[c] * sample.radiance[c];
    d_raw.plane(1 + c)[s] += d_log * gate;
    if (d_base == nullptr) continue;
    d_base[kBaseLogRadiance + c] += d_log;
    d_base[kBaseGate + c] += d_log * residual;
  }
}

template <class T>
void decode_static_backward(const Image<T>& raw, int s, const T* base, T prior, const FieldSample<T>& sample,
                            const FieldSample<T>& d, Image<T>& d_raw) {
  decode_density_backward(raw, s, prior, sample, d, d_raw);
  decode_radiance_backward(raw, s, base, sample, d, d_raw, static_cast<T*>(nullptr));
  d_raw.plane(StaticHead::kBlend)[s] += d.blend * sample.blend * (1 - sample.blend);
}

// Returns d_prior.
template <class T>
T decode_dynamic_backward(const Image<T>& raw, int s, const T* base, T prior, const FieldSample<T>& sample,
                          const FieldSample<T>& d, Image<T>& d_raw, T* d_base) {
  decode_radiance_backward(raw, s, base, sample, d, d_raw, d_base);
  for (int k = 0; k < 2; ++k) {
    for (int a = 0; a < 3; ++a) {
      d_raw.plane(DynamicHead::kFlow + 3 * k + a)[s] += d.flow[k][a] + d.flow_residual[k][a];
      if (d_base != nullptr && a < 2) d_base[kBaseFlow + 2 * k + a] += d.flow[k][a];
    }
    d_raw.plane(DynamicHead::kOcclusion + k)[s] +=
        d.occlusion[k] * sample.occlusion[k] * (1 - sample.occlusion[k]);
  }
  return decode_density_backward(raw, s, prior, sample, d, d_raw);
}

}  // namespace hdrcam
