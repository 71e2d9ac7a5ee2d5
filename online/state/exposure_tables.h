// The radiance of a code at one exposure, and the noise of a sample of a given radiance: tables, built once
// per distinct exposure of the cycle from response and noise model. Value type, reentrant.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "capture/noise_model.h"
#include "online/response/response.h"
#include "online/state/pass_constants.h"

namespace hdrcam {

// Measured variance of one exposure's samples in excess of the noise model, by channel and predicted relative
// exposure, in relative exposure squared (sample_residuals.h). Bins are half stops and also resolve the range
// below the first code, where a sample carries almost no information.
struct VarianceExcess {
  static constexpr std::size_t kBins = 32;  // down to 16 stops below full exposure
  std::array<std::array<float, kBins>, 3> bins{};

  // Position of a relative exposure among the bins' centres.
  static float place_of(float x) {
    using namespace pass_constants;
    return std::clamp(-kBinsPerStop * std::log2(std::max(x, kLeastExposure)) - 0.5f, 0.f,
                      static_cast<float>(kBins - 1));
  }
  float at(std::size_t channel, float x) const { return at_place(channel, place_of(x)); }
  float at_place(std::size_t channel, float place) const {
    const auto i = std::min(static_cast<std::size_t>(place), kBins - 2);
    const auto& b = bins[channel];
    return b[i] + (b[i + 1] - b[i]) * (place - static_cast<float>(i));
  }
};

class ExposureTables {
 public:
  // exposure: relative, E / E_ref
  ExposureTables(const Response& response, const NoiseModel& noise, float exposure,
                 const VarianceExcess& excess = {})
      : exposure_(exposure) {
    rebuild(response, noise, excess);
  }
  // A sample's variance is the sum of noise variance, response uncertainty and measured excess.
  void rebuild(const Response& response, const NoiseModel& noise, const VarianceExcess& excess = {});

  float exposure() const { return exposure_; }
  // The share of its surroundings' contrast (variance of 3x3 pixels) that a sample's variance has on top of
  // the tables (online/state/texture_error.h).
  float texture_error() const { return texture_error_; }
  void set_texture_error(float share) { texture_error_ = share; }
  // 0..1: how far the camera's processing changes a code by its surroundings, as compression and noise
  // reduction do: cameras with noise in their codes. It leaves codes below white in what is clipped, too.
  float ringing() const { return ringing_; }
  // Whether a sample's variance goes by the contrast around it.
  bool doubts_textures() const { return texture_error_ > 0 || ringing_ > 0; }
  const VarianceExcess& excess() const { return excess_; }

  // Half a code: what is darker cannot be told from none.
  float least_radiance(int channel) const { return radiance(channel, 0.5f); }

  // code 0..255 -> radiance
  float radiance(int channel, float code) const {
    const auto& table = radiance_[static_cast<std::size_t>(channel)];
    const float z = std::clamp(code, 0.f, 255.f);
    const auto i = static_cast<std::size_t>(z);
    return table[i] + (table[i + 1] - table[i]) * (z - static_cast<float>(i));
  }
  // radiance -> code 0..255, clipped
  float code(int channel, float radiance) const {
    const float root = root_of(radiance);
    const auto i = static_cast<std::size_t>(root);
    const auto& table = code_[static_cast<std::size_t>(channel)];
    return table[i] + (table[i + 1] - table[i]) * (root - static_cast<float>(i));
  }
  // variance of a sample of a pixel with this `radiance`: the best current estimate, never the sample itself,
  // which would favour samples that noise made dark
  float variance(int channel, float radiance) const {
    return variance_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(root_of(radiance))];
  }
  // What such processing hides of a texture, as variance of a sample of a pixel with this `radiance`: all of
  // a local `contrast` (variance of 3x3 pixels) that is small, and no more than some codes of a large one.
  float hidden_texture(int channel, float radiance, float contrast) const {
    const float most =
        hidden_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(root_of(radiance))];
    return contrast * most / (contrast + most + pass_constants::kTiny);
  }
  // The tables themselves, for kernels that look up on their own: radiance by code [kCodes], variance by
  // kSegments sqrt(relative exposure) [kRoots], code and the most that is hidden of a texture by the same.
  std::span<const float> radiances(int channel) const { return radiance_[static_cast<std::size_t>(channel)]; }
  std::span<const float> variances(int channel) const { return variance_[static_cast<std::size_t>(channel)]; }
  std::span<const float> codes(int channel) const { return code_[static_cast<std::size_t>(channel)]; }
  std::span<const float> hidden(int channel) const { return hidden_[static_cast<std::size_t>(channel)]; }

 private:
  static constexpr int kSegments = pass_constants::kSegments;  // uniform in sqrt(x)
  // The place among the segments of a pixel with this `radiance`.
  float root_of(float radiance) const {
    return std::sqrt(std::clamp(radiance * exposure_, 0.f, 1.f)) * kSegments;
  }
  float exposure_, texture_error_ = 0, ringing_ = 0;
  VarianceExcess excess_;
  std::array<std::array<float, pass_constants::kCodes>, 3> radiance_{};
  std::array<std::array<float, pass_constants::kRoots>, 3> variance_{}, code_{}, hidden_{};
};

}  // namespace hdrcam
