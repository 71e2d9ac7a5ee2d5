// What a code means at one exposure: radiance, and the noise of a sample of a given radiance. Built once per
// distinct exposure of the cycle from response and noise model; then only looked up. Value type, reentrant.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "capture/noise_model.h"
#include "online/response/response.h"

namespace hdrcam {

class ExposureTables {
 public:
  // exposure: relative, E / E_ref
  ExposureTables(const Response& response, const NoiseModel& noise, float exposure) : exposure_(exposure) {
    rebuild(response, noise);
  }
  void rebuild(const Response& response, const NoiseModel& noise);

  float exposure() const { return exposure_; }

  // code 0..255 -> radiance
  float radiance(int channel, float code) const {
    const auto& table = radiance_[static_cast<std::size_t>(channel)];
    const float z = std::clamp(code, 0.f, 255.f);
    const auto i = static_cast<std::size_t>(z);
    return table[i] + (table[i + 1] - table[i]) * (z - static_cast<float>(i));
  }
  // variance of a sample of a pixel whose radiance is `radiance`: of the best current estimate, never of the
  // sample itself, which would favour samples that noise made dark
  float variance(int channel, float radiance) const {
    const float root = std::sqrt(std::clamp(radiance * exposure_, 0.f, 1.f)) * kSegments;
    return variance_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(root)];
  }
  // radiance -> code 0..255, clipped
  float code(int channel, float radiance) const {
    const float root = std::sqrt(std::clamp(radiance * exposure_, 0.f, 1.f)) * kSegments;
    const auto i = static_cast<std::size_t>(root);
    const auto& table = code_[static_cast<std::size_t>(channel)];
    return table[i] + (table[i + 1] - table[i]) * (root - static_cast<float>(i));
  }

 private:
  static constexpr int kSegments = 2048;  // uniform in sqrt(x)
  float exposure_;
  std::array<std::array<float, 257>, 3> radiance_{};
  std::array<std::array<float, kSegments + 2>, 3> variance_{}, code_{};
};

}  // namespace hdrcam
