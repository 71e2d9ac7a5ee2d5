// The readable twins of field_kernels.h, which tests compare with them, and through which gradients are
// checked in double precision: scalar type T as in hash_grid.h. Shapes are those of the kernels. Reentrant.
#pragma once

#include <cmath>
#include <cstddef>

#include "online/scene/hash_grid/field/grid_corners.h"

namespace hdrcam::plain {

template <class T>
void encode(const HashLevel& level, const T* table, const GridSamples<T>& at, T* feature0, T* feature1) {
  for (int s = 0; s < at.n; ++s) {
    const T position[3] = {at.position.plane(0)[s], at.position.plane(1)[s], at.position.plane(2)[s]};
    const auto corners = grid_corners(level, position, at.slot[static_cast<std::size_t>(s)]);
    feature0[s] = feature1[s] = 0;
    for (int c = 0; c < 8; ++c) {
      feature0[s] += corners.weight[c] * table[2 * corners.entry[c]];
      feature1[s] += corners.weight[c] * table[2 * corners.entry[c] + 1];
    }
  }
}

template <class T>
void scatter(const HashLevel& level, T* d_table, const GridSamples<T>& at, const T* d_feature0,
             const T* d_feature1) {
  for (int s = 0; s < at.n; ++s) {
    const T position[3] = {at.position.plane(0)[s], at.position.plane(1)[s], at.position.plane(2)[s]};
    const auto corners = grid_corners(level, position, at.slot[static_cast<std::size_t>(s)]);
    for (int c = 0; c < 8; ++c) {
      d_table[2 * corners.entry[c]] += corners.weight[c] * d_feature0[s];
      d_table[2 * corners.entry[c] + 1] += corners.weight[c] * d_feature1[s];
    }
  }
}

template <class T>
void position_backward(const HashLevel& level, const T* table, const GridSamples<T>& at, const T* d_feature0,
                       const T* d_feature1, Image<T>& d_position) {
  for (int s = 0; s < at.n; ++s) {
    const T position[3] = {at.position.plane(0)[s], at.position.plane(1)[s], at.position.plane(2)[s]};
    const auto corners = grid_corners(level, position, at.slot[static_cast<std::size_t>(s)]);
    for (unsigned axis = 0; axis < 3; ++axis) {
      if (!corners.inside[axis]) continue;
      T slope = 0;
      for (unsigned c = 0; c < 8; ++c) {
        T weight = (c >> axis) & 1 ? T(1) : T(-1);
        for (unsigned other = 0; other < 3; ++other)
          if (other != axis)
            weight *= (c >> other) & 1 ? corners.fraction[other] : 1 - corners.fraction[other];
        slope += weight * (d_feature0[s] * table[2 * corners.entry[c]] +
                           d_feature1[s] * table[2 * corners.entry[c] + 1]);
      }
      d_position.plane(static_cast<int>(axis))[s] += slope * static_cast<T>(level.cells[axis]);
    }
  }
}

template <class T>
void affine(const LayerSize& size, const T* w, const T* b, const T* x, bool relu, T* y) {
  const auto [in, out, ld, n] = size;
  for (int o = 0; o < out; ++o)
    for (int s = 0; s < n; ++s) {
      T sum = b[o];
      for (int i = 0; i < in; ++i) sum += w[o * in + i] * x[i * ld + s];
      y[o * ld + s] = relu && sum < 0 ? 0 : sum;
    }
}

template <class T>
void affine_transposed(const LayerSize& size, const T* w, const T* dy, const T* active, T* dx) {
  const auto [in, out, ld, n] = size;
  for (int i = 0; i < in; ++i)
    for (int s = 0; s < n; ++s) {
      T sum = 0;
      for (int o = 0; o < out; ++o) sum += w[o * in + i] * dy[o * ld + s];
      dx[i * ld + s] = active != nullptr && !(active[i * ld + s] > 0) ? 0 : sum;
    }
}

template <class T>
void outer(const LayerSize& size, const T* dy, const T* x, T* dw, T* db) {
  const auto [in, out, ld, n] = size;
  for (int o = 0; o < out; ++o)
    for (int s = 0; s < n; ++s) {
      for (int i = 0; i < in; ++i) dw[o * in + i] += dy[o * ld + s] * x[i * ld + s];
      db[o] += dy[o * ld + s];
    }
}

inline void adam(const AdamStep& step, std::size_t n, float* parameter, float* gradient, float* mean,
                 float* variance) {
  for (std::size_t i = 0; i < n; ++i) {
    if (gradient[i] == 0) continue;
    const float g = gradient[i] * step.gradient_scale;
    mean[i] = step.beta1 * mean[i] + (1 - step.beta1) * g;
    variance[i] = step.beta2 * variance[i] + (1 - step.beta2) * g * g;
    parameter[i] -= step.rate * mean[i] / (std::sqrt(variance[i]) + step.epsilon);
    gradient[i] = 0;
  }
}

}  // namespace hdrcam::plain
