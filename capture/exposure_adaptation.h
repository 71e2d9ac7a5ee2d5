// Adapts the cycle to the light: averages the clipped and dark shares of the frames of each slot, and after a
// few cycles proposes a new cycle (exposure_advice.h). Then it waits until frames of the new cycle arrive.
// Thread-bound; no allocation.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "capture/exposure_advice.h"

namespace hdrcam {

class ExposureAdaptation {
 public:
  using Cycle = std::array<Exposure, ExposureSchedule::kMaxSlots>;

  // shortest, longest: exposure times that the sensor can do within a frame; gain_max: analogue.
  ExposureAdaptation(std::span<const Exposure> cycle, Duration shortest, Duration longest, double gain_max);

  // Adds a frame whose slot and exposure are certain. Returns the next cycle (its first slots() entries)
  // where it should change.
  std::optional<Cycle> observe(int slot, const SlotShares& shares);
  int slots() const { return slots_; }

 private:
  static constexpr int kCycles = 4;    // averaged before it proposes a change
  static constexpr int kSettling = 5;  // queued cycles when the schedule changes

  Cycle cycle_{};
  const int slots_;
  const Duration shortest_, longest_;
  const double gain_max_;
  std::array<SlotShares, ExposureSchedule::kMaxSlots> sums_{};
  std::array<int, ExposureSchedule::kMaxSlots> counts_{};
  int waiting_ = 0;  // frames until the new cycle arrives
};

}  // namespace hdrcam
