// Follows the light: gathers what the frames of each slot lost to clipping and to the dark, and after a few
// cycles says what the cycle should become (exposure_advice.h). Then it waits until frames of the new cycle
// have come back. Thread-bound; no allocation.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "capture/exposure_advice.h"

namespace hdrcam {

class ExposureAdaptation {
 public:
  using Cycle = std::array<Exposure, ExposureSchedule::kMaxSlots>;

  // shortest, longest: times that the sensor can do within a frame; gain_max: analogue.
  ExposureAdaptation(std::span<const Exposure> cycle, Duration shortest, Duration longest, double gain_max);

  // A frame of a slot whose exposure is certain. Returns the next cycle (its first slots() entries) where it
  // should change.
  std::optional<Cycle> observe(int slot, const SlotShares& shares);
  int slots() const { return slots_; }

 private:
  static constexpr int kCycles = 4;    // gathered before it speaks
  static constexpr int kSettling = 5;  // cycles under way when the schedule changes

  Cycle cycle_{};
  const int slots_;
  const Duration shortest_, longest_;
  const double gain_max_;
  std::array<SlotShares, ExposureSchedule::kMaxSlots> sums_{};
  std::array<int, ExposureSchedule::kMaxSlots> counts_{};
  int waiting_ = 0;  // frames until the new cycle is back
};

}  // namespace hdrcam
