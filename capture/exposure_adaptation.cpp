#include "capture/exposure_adaptation.h"

#include <algorithm>

namespace hdrcam {

ExposureAdaptation::ExposureAdaptation(const ExposureLimits& limits)
    : limits_(limits), slots_(static_cast<int>(limits.cycle.size())) {
  std::ranges::copy(limits.cycle, cycle_.begin());
}

std::optional<ExposureAdaptation::Cycle> ExposureAdaptation::observe(int slot, const SlotShares& shares) {
  if (slot < 0 || slot >= slots_) return std::nullopt;
  if (waiting_ > 0) return --waiting_, std::nullopt;
  const auto at = static_cast<std::size_t>(slot);
  sums_[at].clipped += shares.clipped, sums_[at].dark += shares.dark;
  ++counts_[at];
  const auto slots = static_cast<std::size_t>(slots_);
  if (std::any_of(counts_.begin(), counts_.begin() + slots_, [](int count) { return count < kCycles; }))
    return std::nullopt;

  std::array<SlotShares, ExposureSchedule::kMaxSlots> means{};
  for (std::size_t i = 0; i < slots; ++i) {
    const auto count = static_cast<float>(counts_[i]);
    means[i] = {sums_[i].clipped / count, sums_[i].dark / count};
  }
  sums_ = {}, counts_ = {};
  const std::span<const Exposure> cycle(cycle_.data(), slots);
  const ExposureAdvice advice = advise(cycle, {means.data(), slots});
  if (!advice.changes()) return std::nullopt;
  const Cycle next = followed(cycle, advice, limits_);
  if (next == cycle_) return std::nullopt;  // the sensor's range is exhausted
  return next;
}

void ExposureAdaptation::runs(std::span<const Exposure> cycle) {
  std::ranges::copy(cycle, cycle_.begin());
  waiting_ = kSettling * slots_;
}

}  // namespace hdrcam
