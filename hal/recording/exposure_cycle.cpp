#include "hal/recording/exposure_cycle.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr std::uint64_t kLongestPeriod = 64;  // no schedule is longer; bounds the search

// The cycle in which `slot_at` gives the slot of each frame (-1: none), or one of period 0 where the
// exposures of a slot do not agree or a slot does not occur.
template <class SlotAt>
ExposureCycle cycle_of(std::span<const FrameFacts> frames, std::size_t period, double tolerance_ev,
                       const SlotAt& slot_at) {
  struct Slot {
    double sum_ev = 0, count = 0;
    double mean_ev() const { return sum_ev / count; }
  };
  std::vector<Slot> slots(period);
  const auto each = [&](const auto& visit) {
    for (const FrameFacts& frame : frames)
      if (const int slot = slot_at(frame); slot >= 0 && frame.has_exposure())
        visit(slots[static_cast<std::size_t>(slot)], std::log2(frame.exposure()));
  };
  each([](Slot& slot, double ev) { slot.sum_ev += ev, slot.count += 1; });
  ExposureCycle cycle;
  for (const Slot& slot : slots) {
    if (slot.count == 0) return {};
    cycle.exposures.push_back(std::exp2(slot.mean_ev()));
  }
  bool agrees = true;
  each([&](const Slot& slot, double ev) { agrees &= std::abs(ev - slot.mean_ev()) <= tolerance_ev; });
  if (!agrees) return {};
  cycle.period = static_cast<int>(period);
  return cycle;
}

ExposureCycle recorded_cycle(std::span<const FrameFacts> frames, double tolerance_ev) {
  int last = -1;
  for (const FrameFacts& frame : frames) last = std::max(last, frame.slot);
  if (last < 0 || last >= static_cast<int>(kLongestPeriod)) return {};
  ExposureCycle cycle = cycle_of(frames, static_cast<std::size_t>(last) + 1, tolerance_ev,
                                 [](const FrameFacts& frame) { return frame.slot; });
  cycle.recorded = cycle.period > 0;
  return cycle;
}

}  // namespace

ExposureCycle find_exposure_cycle(std::span<const FrameFacts> frames, double tolerance_ev) {
  if (frames.size() < 2) return {};
  if (ExposureCycle cycle = recorded_cycle(frames, tolerance_ev); cycle.recorded) return cycle;
  std::uint64_t range = 0;
  for (const FrameFacts& frame : frames) {
    if (frame.sequence < frames.front().sequence) return {};  // the counter ran backward and is not usable
    range = std::max(range, frame.sequence - frames.front().sequence + 1);
  }
  for (std::uint64_t period = 1;
       period <= std::min({kLongestPeriod, range / 2, std::uint64_t{frames.size()}}); ++period)
    if (auto cycle = cycle_of(frames, period, tolerance_ev,
                              [&](const FrameFacts& frame) {
                                return static_cast<int>((frame.sequence - frames.front().sequence) % period);
                              });
        cycle.period > 0)
      return cycle;
  return {};
}

int slot_of(const ExposureCycle& cycle, const FrameFacts& first, const FrameFacts& frame) {
  if (cycle.recorded) return frame.slot < cycle.period ? frame.slot : -1;
  if (cycle.period == 0 || frame.sequence < first.sequence) return -1;
  return static_cast<int>((frame.sequence - first.sequence) % static_cast<std::uint64_t>(cycle.period));
}

}  // namespace hdrcam
