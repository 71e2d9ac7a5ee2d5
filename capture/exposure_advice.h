// What the next cycle of exposures should be, from how much of each frame is clipped or lost in the dark. A
// value: the pipeline carries it back to the schedule, which decides. Reentrant.
#pragma once

#include <array>
#include <span>

#include "capture/exposure_schedule.h"

namespace hdrcam {

// Of the frames of one slot, over the last cycles.
struct SlotShares {
  float clipped = 0, dark = 0;  // of the picture, 0..1
};

struct ExposureAdvice {
  std::array<float, ExposureSchedule::kMaxSlots> stops{};  // to add to each slot; 0: leave it
  bool changes() const;
};

// The shortest exposure should keep all highlights but lamps, the longest should leave little in the dark;
// those between keep their place in the ladder. At most one stop at a time, so that the fit can follow; a
// wide dead zone, so that it rests. cycle and shares: one per slot.
ExposureAdvice advise(std::span<const Exposure> cycle, std::span<const SlotShares> shares);

// The cycle with the advice followed: by time up to `longest`, then by gain up to `gain_max`.
std::array<Exposure, ExposureSchedule::kMaxSlots> followed(std::span<const Exposure> cycle,
                                                           const ExposureAdvice& advice, Duration longest,
                                                           double gain_max);

}  // namespace hdrcam
