#include "online/response/exposure_corrections.h"

#include <cmath>

namespace hdrcam {

float ExposureCorrections::corrected(float exposure) const {
  const auto found = log_ratios_.find(key(exposure));
  return found == log_ratios_.end() ? exposure : exposure * static_cast<float>(std::exp(found->second));
}

int ExposureCorrections::key(float exposure) {
  return static_cast<int>(std::lround(std::log2(exposure) * 64));
}

}  // namespace hdrcam
