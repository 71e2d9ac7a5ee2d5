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
  auto nearest = log_ratios_.lower_bound(wanted);
  if (nearest != log_ratios_.begin()) {
    const auto below = std::prev(nearest);
    if (nearest == log_ratios_.end() || wanted - below->first <= nearest->first - wanted) nearest = below;
  }
  if (nearest == log_ratios_.end() || std::abs(nearest->first - wanted) > kReach) return exposure;
  return exposure * static_cast<float>(std::exp(nearest->second));
}

std::vector<ExposureCorrection> ExposureCorrections::learned() const {
  std::vector<ExposureCorrection> all;
  for (const auto& [key, log_ratio] : log_ratios_)
    all.push_back({exposure_of(key), static_cast<float>(log_ratio / std::numbers::ln2)});
  return all;
}

int ExposureCorrections::key(float exposure) {
  return static_cast<int>(std::lround(std::log2(exposure) * kKeysPerStop));
}

float ExposureCorrections::exposure_of(int key) { return std::exp2(static_cast<float>(key) / kKeysPerStop); }

}  // namespace hdrcam
