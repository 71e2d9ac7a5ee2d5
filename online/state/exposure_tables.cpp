#include "online/state/exposure_tables.h"

#include "hal/core/smooth_step.h"

namespace hdrcam {

void ExposureTables::rebuild(const Response& response, const NoiseModel& noise,
                             const VarianceExcess& excess) {
  // Below it the slope of the response is uncertain: the largest nearby is used.
  constexpr float kDarkCode = 10;
  constexpr int kBlackCode = 4, kSureCode = 8;
  constexpr float kClean = 0.25f, kRings = 0.75f;  // codes rms
  // Noise is measured in smooth places, where compression leaves less: variance, of code noise.
  constexpr float kBeyondSmooth = 3;
  constexpr float kHiddenTexture = 4;  // codes rms
  excess_ = excess;
  ringing_ = smooth_step(kClean, kRings, noise.code_noise);
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    for (std::size_t z = 0; z < 256; ++z) radiance_[channel][z] = response.inverse(c)[z] / exposure_;
    radiance_[channel][256] = radiance_[channel][255];
    for (std::size_t i = 0; i <= kSegments + 1; ++i) {
      const float root = std::min(1.f, static_cast<float>(i) / kSegments);
      const float x = root * root;
      const float code = response.code_of(c, x);
      float slope = response.slope(c, code);
      if (code < kDarkCode)
        for (int d = -2; d <= 2; ++d)
          slope = std::max(slope, response.slope(c, code + static_cast<float>(d)));
      const float per_code = slope * slope;
      float variance = noise.exposure_variance(x) +
                       per_code * (1 + kBeyondSmooth * ringing_) * noise.code_variance() +
                       excess.at(channel, x);
      // near black a code is a bound more than a measurement: what is darker, or was made so, reads the same
      const float bound = response.inverse(c)[kBlackCode] * (1 - smooth_step(kBlackCode, kSureCode, code));
      const float doubt = x * response.uncertainty(c, code);
      variance += bound * bound + doubt * doubt;
      variance_[channel][i] = variance / (exposure_ * exposure_);
      code_[channel][i] = code;
      hidden_[channel][i] = kHiddenTexture * kHiddenTexture * ringing_ * per_code / (exposure_ * exposure_);
    }
  }
}

}  // namespace hdrcam
