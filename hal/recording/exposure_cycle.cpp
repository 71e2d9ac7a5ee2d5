#include "hal/recording/exposure_cycle.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {

void ExposureCycleSearch::SlotExposures::add(double ev) {
  sum_ev += ev, count += 1;
  least_ev = std::min(least_ev, ev), most_ev = std::max(most_ev, ev);
}

bool ExposureCycleSearch::SlotExposures::agree() const {
  constexpr double kTolerance_ev = 0.3;  // from the mean
  return mean_ev() - least_ev <= kTolerance_ev && most_ev - mean_ev() <= kTolerance_ev;
}

// One of period 0 where the exposures of a slot do not agree or a slot does not occur.
ExposureCycle ExposureCycleSearch::cycle_of(std::span<const SlotExposures> slots) {
  ExposureCycle cycle;
  for (const SlotExposures& slot : slots) {
    if (slot.count == 0 || !slot.agree()) return {};
    cycle.exposures.push_back(std::exp2(slot.mean_ev()));
  }
  cycle.period = static_cast<int>(slots.size());
  return cycle;
}

void ExposureCycleSearch::add(const FrameFacts& frame) {
  if (frames_++ == 0) first_ = frame.sequence;
  runs_backward_ |= frame.sequence < first_;
  const std::uint64_t place = frame.sequence - first_;
  range_ = std::max(range_, place + 1);
  last_stated_ = std::max(last_stated_, frame.slot);
  if (!frame.has_exposure()) return;
  const double ev = std::log2(frame.exposure());
  if (frame.slot >= 0 && frame.slot < static_cast<int>(kLongestPeriod))
    stated_[static_cast<std::size_t>(frame.slot)].add(ev);
  for (std::size_t period = 1; period <= kLongestPeriod; ++period)
    counted_[first_slot(period) + place % period].add(ev);
}

ExposureCycle ExposureCycleSearch::cycle() const {
  if (frames_ < 2) return {};
  if (last_stated_ >= 0 && last_stated_ < static_cast<int>(kLongestPeriod)) {
    const std::size_t period = static_cast<std::size_t>(last_stated_) + 1;
    ExposureCycle stated = cycle_of(std::span(stated_).first(period));
    stated.recorded = stated.period > 0;
    if (stated.recorded) return stated;
  }
  if (runs_backward_) return {};
  const std::uint64_t longest = std::min({std::uint64_t{kLongestPeriod}, range_ / 2, frames_});
  for (std::size_t period = 1; period <= longest; ++period) {
    ExposureCycle found = cycle_of(std::span(counted_).subspan(first_slot(period), period));
    if (found.period > 0) return found;
  }
  return {};
}

ExposureCycle find_exposure_cycle(std::span<const FrameFacts> frames) {
  ExposureCycleSearch search;
  for (const FrameFacts& frame : frames) search.add(frame);
  return search.cycle();
}

int slot_of(const ExposureCycle& cycle, const FrameFacts& first, const FrameFacts& frame) {
  if (cycle.recorded) return frame.slot < cycle.period ? frame.slot : -1;
  if (cycle.period == 0 || frame.sequence < first.sequence) return -1;
  return static_cast<int>((frame.sequence - first.sequence) % static_cast<std::uint64_t>(cycle.period));
}

}  // namespace hdrcam
