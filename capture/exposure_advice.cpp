#include "capture/exposure_advice.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hdrcam {
namespace {

// Shares of the picture of the shortest exposure: what lamps and the sun itself may clip, what counts as
// nothing, and from where on it is too dark to be of use.
constexpr float kMostClipped = 0.01f, kNoneClipped = 0.001f, kAllDark = 0.9f;
// Of the longest exposure: likewise of the dark; where nearly all is clipped, more light adds nothing, and
// where much is, less light loses nothing.
constexpr float kMostDark = 0.05f, kNoneDark = 0.005f, kAllClipped = 0.9f, kMuchClipped = 0.6f;
constexpr float kStep = 1;            // stops
constexpr double kClosest_stops = 1;  // of two neighbours in the cycle

// If too much is lost at this end, the exposure moves a step. If nothing is lost here but the other end of
// the same frame suffers, it moves back by a smaller step.
float shortest_stops(const SlotShares& shares) {
  if (shares.clipped > kMostClipped) return -kStep;
  if (shares.clipped < kNoneClipped && shares.dark > kAllDark) return kStep / 2;
  return 0;
}

float longest_stops(const SlotShares& shares) {
  if (shares.dark > kMostDark && shares.clipped < kAllClipped) return kStep;
  if (shares.dark < kNoneDark && shares.clipped > kMuchClipped) return -kStep / 2;
  return 0;
}

}  // namespace

ExposureAdvice advise(const SlotShares& shortest, const SlotShares& longest) {
  return {shortest_stops(shortest), longest_stops(longest)};
}

CycleEnds ends_of(std::span<const Exposure> cycle) {
  const auto order = [](const Exposure& a, const Exposure& b) { return a.product() < b.product(); };
  const auto [shortest, longest] = std::minmax_element(cycle.begin(), cycle.end(), order);
  return {static_cast<std::size_t>(shortest - cycle.begin()),
          static_cast<std::size_t>(longest - cycle.begin())};
}

ExposureSchedule::Cycle followed(std::span<const Exposure> cycle, const ExposureAdvice& advice,
                                 const ExposureLimits& limits) {
  HDRCAM_CHECK_EQ(cycle.size(), limits.cycle.size());
  const CycleEnds ends = ends_of(limits.cycle);
  const double asked_low = log_product(limits.cycle[ends.shortest]);
  const double asked_span = log_product(limits.cycle[ends.longest]) - asked_low;
  const double least = std::log(to_seconds(limits.shortest) * limits.least_gain);
  const double greatest = std::log(to_seconds(limits.longest) * limits.greatest_gain);
  const auto moved = [&](std::size_t slot, float stops) {
    return std::clamp(log_product(cycle[slot]) + stops * std::numbers::ln2, least, greatest);
  };
  double low = moved(ends.shortest, advice.shortest), high = moved(ends.longest, advice.longest);
  const double closest =
      std::min(asked_span, static_cast<double>(cycle.size() - 1) * kClosest_stops * std::numbers::ln2);
  if (high - low < closest && advice.longest >= 0)
    low = std::max(least, high - closest);  // the short end came too near
  else if (high - low < closest)
    high = std::min(greatest, low + closest);

  ExposureSchedule::Cycle next(cycle);
  for (std::size_t i = 0; i < cycle.size(); ++i) {
    const double place = asked_span > 0 ? (log_product(limits.cycle[i]) - asked_low) / asked_span : 0;
    const double product = std::exp(low + place * (high - low));
    const double time =
        std::clamp(product / limits.least_gain, to_seconds(limits.shortest), to_seconds(limits.longest));
    next[i] = {from_seconds(time), std::clamp(product / time, limits.least_gain, limits.greatest_gain)};
  }
  return next;
}

}  // namespace hdrcam
