#include "online/response/exposure_corrections.h"

#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numbers>

#include "capture/exposure.h"

namespace hdrcam {
namespace {

constexpr int kKeysPerStop = 64;

}  // namespace

float ExposureCorrections::corrected(float exposure) const {
  constexpr auto kReach = static_cast<int>(kSameExposure / std::numbers::ln2 * kKeysPerStop);
  const int wanted = key(exposure);
  auto nearest = learned_.lower_bound(wanted);
  if (nearest != learned_.begin()) {
    const auto below = std::prev(nearest);
    if (nearest == learned_.end() || wanted - below->first <= nearest->first - wanted) nearest = below;
  }
  if (nearest == learned_.end() || std::abs(nearest->first - wanted) > kReach) return exposure;
  return exposure * static_cast<float>(std::exp(nearest->second.log_ratio));
}

std::vector<ExposureCorrection> ExposureCorrections::learned() const {
  std::vector<ExposureCorrection> all;
  for (const auto& [key, exposure] : learned_)
    all.push_back({exposure.stated, static_cast<float>(exposure.log_ratio / std::numbers::ln2)});
  return all;
}

int ExposureCorrections::key(float exposure) {
  return static_cast<int>(std::lround(std::log2(exposure) * kKeysPerStop));
}

}  // namespace hdrcam
