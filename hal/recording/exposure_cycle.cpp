#include "hal/recording/exposure_cycle.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr std::uint64_t kLongestPeriod = 64;  // no schedule is longer; bounds the search

bool is_exposure(double exposure) { return exposure > 0 && std::isfinite(exposure); }

// The cycle of this period, or one of period 0 where it does not hold.
ExposureCycle cycle_of(std::span<const FrameFacts> frames, std::uint64_t period, double tolerance_ev) {
  struct Slot {
    double sum_ev = 0, count = 0;
  };
  std::vector<Slot> slots(period);
  const auto slot_at = [&](const FrameFacts& frame) -> Slot& {
    return slots[(frame.sequence - frames.front().sequence) % period];
  };
  for (const FrameFacts& frame : frames)
    if (is_exposure(frame.exposure()))
      slot_at(frame).sum_ev += std::log2(frame.exposure()), slot_at(frame).count += 1;
  ExposureCycle cycle;
  for (const Slot& slot : slots) {
    if (slot.count == 0) return {};
    cycle.exposures.push_back(std::exp2(slot.sum_ev / slot.count));
  }
  for (const FrameFacts& frame : frames) {
    const Slot& slot = slot_at(frame);
    if (is_exposure(frame.exposure()) &&
        std::abs(std::log2(frame.exposure()) - slot.sum_ev / slot.count) > tolerance_ev)
      return {};
  }
  cycle.period = static_cast<int>(period);
  return cycle;
}

}  // namespace

ExposureCycle find_exposure_cycle(std::span<const FrameFacts> frames, double tolerance_ev) {
  if (frames.size() < 2) return {};
  std::uint64_t range = 0;
  for (const FrameFacts& frame : frames) {
    if (frame.sequence < frames.front().sequence)
      return {};  // the counter ran backwards: nothing to count by
    range = std::max(range, frame.sequence - frames.front().sequence + 1);
  }
  for (std::uint64_t period = 1;
       period <= std::min({kLongestPeriod, range / 2, std::uint64_t{frames.size()}}); ++period)
    if (auto cycle = cycle_of(frames, period, tolerance_ev); cycle.period > 0) return cycle;
  return {};
}

int slot_of(const ExposureCycle& cycle, const FrameFacts& first, const FrameFacts& frame) {
  if (cycle.period == 0 || frame.sequence < first.sequence) return -1;
  return static_cast<int>((frame.sequence - first.sequence) % static_cast<std::uint64_t>(cycle.period));
}

}  // namespace hdrcam
