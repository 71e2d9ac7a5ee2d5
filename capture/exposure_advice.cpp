#include "capture/exposure_advice.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr float kMostClipped = 0.01f;  // of the shortest exposure: lamps and the sun itself
constexpr float kNoneClipped = 0.001f;
constexpr float kMostDark = 0.05f;  // of the longest exposure
constexpr float kNoneDark = 0.005f;
constexpr float kStep = 1;  // stops

// If too much is lost at this end, the exposure moves a step. If nothing is lost here but the other end of
// the same frame suffers, it moves back by a smaller step.
float shortest_stops(const SlotShares& shares) {
  if (shares.clipped > kMostClipped) return -kStep;
  if (shares.clipped < kNoneClipped && shares.dark > 0.9f) return kStep / 2;
  return 0;
}

float longest_stops(const SlotShares& shares) {
  if (shares.dark > kMostDark && shares.clipped < 0.9f) return kStep;
  if (shares.dark < kNoneDark && shares.clipped > 0.6f) return -kStep / 2;
  return 0;
}

}  // namespace

bool ExposureAdvice::changes() const {
  return std::any_of(stops.begin(), stops.end(), [](float stop) { return stop != 0; });
}

ExposureAdvice advise(std::span<const Exposure> cycle, std::span<const SlotShares> shares) {
  HDRCAM_CHECK_EQ(cycle.size(), shares.size());
  ExposureAdvice advice;
  if (cycle.size() < 2) return advice;
  const auto order = [](const Exposure& a, const Exposure& b) { return a.product() < b.product(); };
  const auto [shortest, longest] = std::minmax_element(cycle.begin(), cycle.end(), order);
  const double low = log_product(*shortest), high = log_product(*longest);
  if (high - low < 0.1) return advice;
  const float at_low = shortest_stops(shares[static_cast<std::size_t>(shortest - cycle.begin())]);
  const float at_high = longest_stops(shares[static_cast<std::size_t>(longest - cycle.begin())]);
  for (std::size_t i = 0; i < cycle.size(); ++i) {
    const auto place = static_cast<float>((log_product(cycle[i]) - low) / (high - low));
    advice.stops[i] = at_low + place * (at_high - at_low);
  }
  return advice;
}

std::array<Exposure, ExposureSchedule::kMaxSlots> followed(std::span<const Exposure> cycle,
                                                           const ExposureAdvice& advice,
                                                           const ExposureLimits& limits) {
  std::array<Exposure, ExposureSchedule::kMaxSlots> next{};
  for (std::size_t i = 0; i < cycle.size(); ++i) {
    const double product = cycle[i].product() * std::exp2(advice.stops[i]);
    const double time =
        std::clamp(product / limits.least_gain, to_seconds(limits.shortest), to_seconds(limits.longest));
    next[i] = {from_seconds(time), std::clamp(product / time, limits.least_gain, limits.greatest_gain)};
  }
  return next;
}

}  // namespace hdrcam
