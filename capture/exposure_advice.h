// Proposes the next cycle of exposures from the shares of its frames that are clipped or too dark. The advice
// is a value: the pipeline carries it back to the schedule, which decides. Reentrant.
#pragma once

#include <cstddef>
#include <span>

#include "capture/exposure_limits.h"
#include "capture/exposure_schedule.h"

namespace hdrcam {

// Shares of the frames of one slot, over the last cycles.
struct SlotShares {
  float clipped = 0, dark = 0;  // of the picture, 0..1
};

// What to add to both ends of the cycle, in stops; 0: leave it.
struct ExposureAdvice {
  float shortest = 0, longest = 0;
  bool changes() const { return shortest != 0 || longest != 0; }
};

// The shortest exposure should keep all highlights except lamps, the longest should leave little in the dark.
// A change is at most one stop, so that the fit can follow, and a wide dead zone prevents oscillation.
ExposureAdvice advise(const SlotShares& shortest, const SlotShares& longest);

// The slots of the shortest and the longest exposure of a cycle of at least one.
struct CycleEnds {
  std::size_t shortest = 0, longest = 0;
};
CycleEnds ends_of(std::span<const Exposure> cycle);

// The cycle that runs with the advice applied, within what sensor and frame allow: first by time at the least
// gain, then by gain. The exposures between keep the place that they have in `limits.cycle`, the one that was
// asked for, wherever an end had to stop; the ends stay a stop for each step apart, or as far as they were
// asked. Else a dark hour would make two exposures one, and nothing could part them again.
ExposureSchedule::Cycle followed(std::span<const Exposure> cycle, const ExposureAdvice& advice,
                                 const ExposureLimits& limits);

}  // namespace hdrcam
