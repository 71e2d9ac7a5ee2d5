#include "capture/exposure_adaptation.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr double kRounding = 1e-6;  // of an exposure's logarithm

}  // namespace

ExposureAdaptation::ExposureAdaptation(const ExposureLimits& limits, int latency_frames)
    : limits_(limits),
      latency_frames_(latency_frames),
      slots_(static_cast<int>(limits.cycle.size())),
      ends_(ends_of(limits.cycle)),
      cycle_(limits.cycle) {}

std::optional<ExposureSchedule::Cycle> ExposureAdaptation::observe(int slot, const SlotShares& shares) {
  if (slot >= slots_ || slots_ < 2) return std::nullopt;
  if (waiting_ > 0) return --waiting_, std::nullopt;
  if (slot < 0) return observe_unknown(shares);
  unknown_ = 0;
  const auto at = static_cast<std::size_t>(slot);
  sums_[at].clipped += shares.clipped, sums_[at].dark += shares.dark;
  ++counts_[at];
  if (std::min(counts_[ends_.shortest], counts_[ends_.longest]) < kCycles) return std::nullopt;

  const auto mean = [&](std::size_t i) {
    const auto count = static_cast<float>(counts_[i]);
    return SlotShares{sums_[i].clipped / count, sums_[i].dark / count};
  };
  const ExposureAdvice advice = advise(mean(ends_.shortest), mean(ends_.longest));
  sums_ = {}, counts_ = {};
  return next(advice);
}

std::optional<ExposureSchedule::Cycle> ExposureAdaptation::observe_unknown(const SlotShares& shares) {
  if (unknown_ == 0) darkest_ = brightest_ = shares;
  darkest_ = {std::min(darkest_.clipped, shares.clipped), std::max(darkest_.dark, shares.dark)};
  brightest_ = {std::max(brightest_.clipped, shares.clipped), std::min(brightest_.dark, shares.dark)};
  if (++unknown_ < kUnknownCycles * slots_) return std::nullopt;
  unknown_ = 0;
  return next(advise(darkest_, brightest_));
}

std::optional<ExposureSchedule::Cycle> ExposureAdaptation::next(const ExposureAdvice& advice) const {
  if (!advice.changes()) return std::nullopt;
  ExposureSchedule::Cycle next = followed(cycle_, advice, limits_);
  const auto same = [](const Exposure& a, const Exposure& b) {
    return std::abs(log_product(a) - log_product(b)) < kRounding;
  };
  if (std::ranges::equal(next, cycle_, same)) return std::nullopt;  // the sensor's range is exhausted
  return next;
}

void ExposureAdaptation::runs(std::span<const Exposure> cycle) {
  cycle_ = ExposureSchedule::Cycle(cycle);
  waiting_ = std::max(kSettling * slots_, latency_frames_), unknown_ = 0;
  sums_ = {}, counts_ = {};
}

}  // namespace hdrcam
