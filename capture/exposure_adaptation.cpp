#include "capture/exposure_adaptation.h"

#include <algorithm>

namespace hdrcam {

ExposureAdaptation::ExposureAdaptation(std::span<const Exposure> cycle, Duration shortest, Duration longest,
                                       double gain_max)
    : slots_(static_cast<int>(cycle.size())), shortest_(shortest), longest_(longest), gain_max_(gain_max) {
  std::copy(cycle.begin(), cycle.end(), cycle_.begin());
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
  Cycle next = followed(cycle, advice, longest_, gain_max_);
  for (std::size_t i = 0; i < slots; ++i) next[i].time = std::max(next[i].time, shortest_);
  if (next == cycle_) return std::nullopt;  // the sensor's range is exhausted
  cycle_ = next;
  waiting_ = kSettling * slots_;
  return next;
}

}  // namespace hdrcam
