#include "online/state/exposure_tables.h"

#include "hal/core/smooth_step.h"

namespace hdrcam {
namespace {

// dx/dz. In the dark the slope of the response is uncertain: the largest nearby is used.
float slope_at(const Response& response, int channel, float code) {
  constexpr float kDarkCode = 10;  // chosen, not measured
  float slope = response.slope(channel, code);
  if (code < kDarkCode)
    for (int d = -2; d <= 2; ++d)
      slope = std::max(slope, response.slope(channel, code + static_cast<float>(d)));
  return slope;
}

// What a code leaves open of x, as variance: by the uncertainty of the response, and near black, where it is
// a bound more than a measurement: what is darker, or was made so, reads the same.
float doubt_of(const Response& response, int channel, float code, float x) {
  constexpr int kBlackCode = 4, kSureCode = 8;  // by ablation against 16 (docs/decisions/state.md)
  const float bound = response.inverse(channel)[kBlackCode] * (1 - smooth_step(kBlackCode, kSureCode, code));
  const float doubt = x * response.uncertainty(channel, code);
  return bound * bound + doubt * doubt;
}

}  // namespace

void ExposureTables::rebuild(const Response& response, const NoiseModel& noise,
                             const VarianceExcess& excess) {
  // Of code noise, codes rms: clean clips have .1, compressed ones .8 and more (docs/decisions/state.md).
  constexpr float kClean = 0.25f, kRings = 0.75f;
  // Noise is measured in smooth places, where compression leaves less: variance that comes on top, in that of
  // code noise. By ablation, as what is hidden (docs/decisions/noise.md).
  constexpr float kBeyondSmooth = 3;
  constexpr float kHiddenTexture = 4;  // codes rms
  static_assert(pass_constants::kCodes == Response::kCodes + 1, "a code and the next one are read together");
  excess_ = excess;
  ringing_ = smooth_step(kClean, kRings, noise.code_noise);
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    for (std::size_t z = 0; z < Response::kCodes; ++z)
      radiance_[channel][z] = response.inverse(c)[z] / exposure_;
    radiance_[channel][Response::kCodes] = radiance_[channel][Response::kCodes - 1];
    for (std::size_t i = 0; i < pass_constants::kRoots; ++i) {
      const float root = std::min(1.f, static_cast<float>(i) / kSegments);
      const float x = root * root;
      const float code = response.code_of(c, x), slope = slope_at(response, c, code);
      const float per_code = slope * slope;
      float variance = noise.exposure_variance(x) +
                       per_code * (1 + kBeyondSmooth * ringing_) * noise.code_variance() +
                       excess.at(channel, x);
      variance += doubt_of(response, c, code, x);
      variance_[channel][i] = variance / (exposure_ * exposure_);
      code_[channel][i] = code;
      hidden_[channel][i] = kHiddenTexture * kHiddenTexture * ringing_ * per_code / (exposure_ * exposure_);
    }
  }
}

}  // namespace hdrcam
