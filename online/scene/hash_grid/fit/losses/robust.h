// The smooth L1 of all losses: rho(e) = sqrt(e^2 + s^2) - s. It approaches the paper's L1 beyond s and has a
// gradient everywhere, which can be checked and descended. Reentrant.
#pragma once

#include <cmath>

namespace hdrcam {

template <class T>
struct Robust {
  T value, slope;
};

template <class T>
Robust<T> robust(T error, T softness) {
  const T root = std::sqrt(error * error + softness * softness);
  return {root - softness, error / root};
}

}  // namespace hdrcam
