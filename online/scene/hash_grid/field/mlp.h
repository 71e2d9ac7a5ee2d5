// A small fully connected network, inputs -> hidden -> hidden -> outputs with rectified hidden layers and a
// linear head, evaluated on a batch with samples innermost ([width, 1, ld]). All widths are multiples of 4.
// Weights are row-major [out, in] followed by the bias, layer after layer, in one span, which is one vector
// for the optimiser. Scalar type T as in hash_grid.h. The network is read-only while it runs: forward and
// backward are reentrant.
#pragma once

#include <cmath>
#include <span>
#include <type_traits>
#include <vector>

#include "hal/core/image.h"
#include "online/scene/hash_grid/field/plain_kernels.h"
#include "online/scene/hash_grid/field/random.h"

namespace hdrcam {

// The activations that backward needs from forward, and scratch memory. [hidden, 1, ld] each.
template <class T>
struct MlpTrace {
  Image<T> hidden[2], d_hidden[2];
};

template <class T>
class Mlp {
 public:
  static constexpr int kLayers = 3;
  static constexpr float kBiasSpread = 0.3f;

  // He initialisation; the head is scaled by head_gain, so that 0 starts every output at its bias.
  Mlp(int inputs, int hidden, int outputs, float head_gain, Pcg32& random)
      : width_{inputs, hidden, hidden, outputs} {
    for (int width : width_) HDRCAM_CHECK(width > 0 && width % 4 == 0);
    for (int layer = 0; layer < kLayers; ++layer) {
      const float bound =
          std::sqrt(6.f / static_cast<float>(width_[layer])) * (layer == kLayers - 1 ? head_gain : 1);
      for (int i = 0; i < width_[layer] * width_[layer + 1]; ++i)
        parameters_.push_back(static_cast<T>(random.uniform(-bound, bound)));
      // hidden biases spread the kinks, so that a unit whose inputs are all zero is not dead
      for (int o = 0; o < width_[layer + 1]; ++o)
        parameters_.push_back(
            layer == kLayers - 1 ? T(0) : static_cast<T>(random.uniform(-kBiasSpread, kBiasSpread)));
    }
  }

  int inputs() const { return width_[0]; }
  int hidden() const { return width_[1]; }
  int outputs() const { return width_[kLayers]; }
  std::span<T> parameters() { return parameters_; }
  std::span<const T> parameters() const { return parameters_; }
  T& head_bias(int output) {
    return parameters_[offset(kLayers) - static_cast<std::size_t>(outputs() - output)];
  }

  // y [outputs, 1, ld] <- x [inputs, 1, ld] for the first n samples
  void forward(const Image<T>& x, int n, MlpTrace<T>& trace, Image<T>& y) const {
    apply(0, x, n, trace.hidden[0]);
    apply(1, trace.hidden[0], n, trace.hidden[1]);
    apply(2, trace.hidden[1], n, y);
  }

  // Adds to d_parameters and writes d_x, from d_y and the trace of forward(x).
  void backward(const Image<T>& x, const Image<T>& d_y, int n, MlpTrace<T>& trace, std::span<T> d_parameters,
                Image<T>& d_x) const {
    layer_backward(2, trace.hidden[1], d_y, n, d_parameters, trace.d_hidden[1]);
    layer_backward(1, trace.hidden[0], trace.d_hidden[1], n, d_parameters, trace.d_hidden[0]);
    layer_backward(0, x, trace.d_hidden[0], n, d_parameters, d_x);
  }

 private:
  static constexpr bool kFast = std::is_same_v<T, float>;

  std::size_t offset(int layer) const {
    int at = 0;
    for (int l = 0; l < layer; ++l) at += (width_[l] + 1) * width_[l + 1];
    return static_cast<std::size_t>(at);
  }
  std::size_t bias_offset(int layer) const {
    return offset(layer) + static_cast<std::size_t>(width_[layer] * width_[layer + 1]);
  }

  LayerSize size_of(int layer, const Image<T>& x, int n) const {
    return {.in = width_[layer], .out = width_[layer + 1], .ld = x.cols(), .n = n};
  }

  void apply(int layer, const Image<T>& x, int n, Image<T>& y) const {
    const T *w = parameters_.data() + offset(layer), *b = parameters_.data() + bias_offset(layer);
    const LayerSize size = size_of(layer, x, n);
    const bool relu = layer < kLayers - 1;
    if constexpr (kFast)
      field_kernels().affine(size, w, b, x.plane(0), relu, y.plane(0));
    else
      plain::affine(size, w, b, x.plane(0), relu, y.plane(0));
  }

  void layer_backward(int layer, const Image<T>& x, const Image<T>& d_y, int n, std::span<T> d_parameters,
                      Image<T>& d_x) const {
    const T* w = parameters_.data() + offset(layer);
    T *d_w = d_parameters.data() + offset(layer), *d_b = d_parameters.data() + bias_offset(layer);
    const LayerSize size = size_of(layer, x, n);
    const T* active = layer > 0 ? x.plane(0) : nullptr;  // the network's input is not rectified
    if constexpr (kFast) {
      field_kernels().outer(size, d_y.plane(0), x.plane(0), d_w, d_b);
      field_kernels().affine_transposed(size, w, d_y.plane(0), active, d_x.plane(0));
    } else {
      plain::outer(size, d_y.plane(0), x.plane(0), d_w, d_b);
      plain::affine_transposed(size, w, d_y.plane(0), active, d_x.plane(0));
    }
  }

  int width_[kLayers + 1];
  std::vector<T> parameters_;
};

}  // namespace hdrcam
