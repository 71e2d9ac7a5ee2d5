#include "online/state/exposure_tables.h"

#include "hal/core/interpolate.h"

namespace hdrcam {

void ExposureTables::rebuild(const Response& response, const NoiseModel& noise,
                             const VarianceExcess& excess) {
  constexpr float kDarkCode =
      10;  // below it the slope of the response is uncertain: the largest nearby is used
  constexpr int kBlackCode = 4, kSureCode = 8;
  excess_ = excess;
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
        for (float d = -2; d <= 2; ++d) slope = std::max(slope, response.slope(c, code + d));
      float variance =
          noise.exposure_variance(x) + slope * slope * noise.code_variance() + excess.at(channel, x);
      // near black a code is a bound more than a measurement: what is darker, or was made so, reads the same
      const float bound = response.inverse(c)[kBlackCode] * (1 - smooth_step(kBlackCode, kSureCode, code));
      const float doubt = x * response.uncertainty(c, code);
      variance += bound * bound + doubt * doubt;
      variance_[channel][i] = variance / (exposure_ * exposure_);
      code_[channel][i] = code;
    }
  }
}

void ExposureTables::codes(int channel, std::span<const float> radiance, float* code) const {
  constexpr std::size_t kBlock = 64;  // the places first, which become vectors, then the look-ups
  std::array<float, kBlock> roots;
  const auto& table = code_[static_cast<std::size_t>(channel)];
  for (std::size_t first = 0; first < radiance.size(); first += kBlock) {
    const std::size_t n = std::min(kBlock, radiance.size() - first);
    const float* in = radiance.data() + first;
    float* out = code + first;
    for (std::size_t k = 0; k < n; ++k) {
      const float x = in[k] * exposure_, positive = x < 0 ? 0.f : x;
      roots[k] = std::sqrt(1 < positive ? 1.f : positive) * kSegments;
    }
    for (std::size_t k = 0; k < n; ++k) {
      const auto i = static_cast<int>(roots[k]);
      const float* at = table.data() + i;
      out[k] = at[0] + (at[1] - at[0]) * (roots[k] - static_cast<float>(i));
    }
  }
}

}  // namespace hdrcam
