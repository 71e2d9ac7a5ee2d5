#include "online/state/exposure_tables.h"

namespace hdrcam {

void ExposureTables::rebuild(const Response& response, const NoiseModel& noise) {
  constexpr float kDarkCode = 10;  // below it the slope of the response is a guess: take the largest nearby
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
      const float variance = noise.exposure_variance(x) + slope * slope * noise.code_variance();
      variance_[channel][i] = variance / (exposure_ * exposure_);
      code_[channel][i] = code;
    }
  }
}

}  // namespace hdrcam
