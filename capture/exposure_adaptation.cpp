#include "capture/exposure_adaptation.h"

#include <algorithm>

namespace hdrcam {

ExposureAdaptation::ExposureAdaptation(const ExposureLimits& limits)
    : limits_(limits), slots_(static_cast<int>(limits.cycle.size())) {
  std::ranges::copy(limits.cycle, cycle_.begin());
}

std::optional<ExposureAdaptation::Cycle> ExposureAdaptation::observe(int slot, const SlotShares& shares) {
  if (slot < 0 || slot >= slots_ || slots_ < 2) return std::nullopt;
  if (waiting_ > 0) return --waiting_, std::nullopt;
  const auto at = static_cast<std::size_t>(slot);
  sums_[at].clipped += shares.clipped, sums_[at].dark += shares.dark;
  ++counts_[at];
  if (std::any_of(counts_.begin(), counts_.begin() + slots_, [](int count) { return count < kCycles; }))
    return std::nullopt;

  const auto mean = [&](std::size_t i) {
    const auto count = static_cast<float>(counts_[i]);
    return SlotShares{sums_[i].clipped / count, sums_[i].dark / count};
  };
  const CycleEnds ends = ends_of(limits_.cycle);
  const ExposureAdvice advice = advise(mean(ends.shortest), mean(ends.longest));
  sums_ = {}, counts_ = {};
  if (!advice.changes()) return std::nullopt;
  const std::span<const Exposure> cycle(cycle_.data(), static_cast<std::size_t>(slots_));
  const Cycle next = followed(cycle, advice, limits_);
  if (next == cycle_) return std::nullopt;  // the sensor's range is exhausted
  return next;
}

void ExposureAdaptation::runs(std::span<const Exposure> cycle) {
  std::ranges::copy(cycle, cycle_.begin());
  waiting_ = kSettling * slots_;
}

}  // namespace hdrcam
