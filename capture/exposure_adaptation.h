// Adapts the cycle to the light: averages the clipped and dark shares of its shortest and its longest
// exposure, and after a few cycles proposes a new cycle (exposure_advice.h). Where the camera takes it, it
// waits until frames of the new cycle arrive; else the old one goes on, and it is asked again later. In the
// dark, and where all is clipped, pictures cannot tell which exposure a frame had: of such frames in a row
// the darkest then stands for the shortest exposure and the brightest for the longest. Thread-bound; no
// allocation after construction.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "capture/exposure_advice.h"
#include "capture/exposure_limits.h"

namespace hdrcam {

class ExposureAdaptation {
 public:
  // latency_frames: until the first frame of a cycle that was asked for comes, as far as that is known.
  ExposureAdaptation(const ExposureLimits& limits, int latency_frames);

  // The slots of the exposures that decide.
  const CycleEnds& ends() const { return ends_; }
  // Adds a frame; slot: one that has its exposure, -1 where that is not certain. Returns the next cycle where
  // it should change.
  std::optional<ExposureSchedule::Cycle> observe(int slot, const SlotShares& shares);
  // From now on the camera is asked for this cycle, of as many exposures.
  void runs(std::span<const Exposure> cycle);

 private:
  static constexpr int kCycles = 4;    // averaged before it proposes a change
  static constexpr int kSettling = 5;  // cycles that it waits at least after a change
  static constexpr int kUnknownCycles = 8;

  std::optional<ExposureSchedule::Cycle> observe_unknown(const SlotShares& shares);
  std::optional<ExposureSchedule::Cycle> next(const ExposureAdvice& advice) const;

  const ExposureLimits limits_;
  const int latency_frames_, slots_;
  const CycleEnds ends_;
  ExposureSchedule::Cycle cycle_;  // that the camera is asked for
  std::array<SlotShares, ExposureSchedule::kMaxSlots> sums_{};
  std::array<int, ExposureSchedule::kMaxSlots> counts_{};
  int waiting_ = 0;                 // frames until the new cycle arrives
  int unknown_ = 0;                 // frames in a row of which nobody knows the exposure
  SlotShares darkest_, brightest_;  // of these
};

}  // namespace hdrcam
