// Adam (Kingma & Ba 2015) on one vector of parameters. Only entries with a gradient change: a step does not
// touch most of a hash table, whose moments must not decay meanwhile. Thread-compatible: distinct vectors on
// distinct threads.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "online/scene/hash_grid/field/field_kernels.h"

namespace hdrcam {

struct AdamOptions {
  float beta1 = 0.9f, beta2 = 0.99f;
  float epsilon = 1e-12f;  // gradients of table entries are small: 1e-6 and below
};

// The moments of one vector.
struct AdamMoments {
  std::vector<float> mean, variance;

  explicit AdamMoments(std::size_t n) : mean(n, 0), variance(n, 0) {}
  void forget() {
    std::fill(mean.begin(), mean.end(), 0.f);
    std::fill(variance.begin(), variance.end(), 0.f);
  }
};

// step: 1, 2, ..: corrects the bias of the moments, which start at 0.
inline AdamStep adam_step(const AdamOptions& options, float rate, float gradient_scale, long step) {
  const auto n = static_cast<float>(step);
  const float correction = std::sqrt(1 - std::pow(options.beta2, n)) / (1 - std::pow(options.beta1, n));
  return {rate * correction, gradient_scale, options.beta1, options.beta2, options.epsilon};
}

// Moves the parameters and clears the gradient.
inline void apply_adam(const AdamStep& step, std::span<float> parameter, std::span<float> gradient,
                       float* mean, float* variance) {
  field_kernels().adam(step, parameter.size(), parameter.data(), gradient.data(), mean, variance);
}

}  // namespace hdrcam
