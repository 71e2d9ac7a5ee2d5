// Proposes the next cycle of exposures from the shares of each frame that are clipped or too dark. The advice
// is a value: the pipeline carries it back to the schedule, which decides. Reentrant.
#pragma once

#include <array>
#include <span>

#include "capture/exposure_limits.h"
#include "capture/exposure_schedule.h"

namespace hdrcam {

// Shares of the frames of one slot, over the last cycles.
struct SlotShares {
  float clipped = 0, dark = 0;  // of the picture, 0..1
};

struct ExposureAdvice {
  std::array<float, ExposureSchedule::kMaxSlots> stops{};  // to add to each slot; 0: leave it
  bool changes() const;
};

// The shortest exposure should keep all highlights except lamps, the longest should leave little in the dark;
// the exposures between keep their relative place. A change is at most one stop, so that the fit can follow,
// and a wide dead zone prevents oscillation. cycle and shares: one per slot.
ExposureAdvice advise(std::span<const Exposure> cycle, std::span<const SlotShares> shares);

// The cycle with the advice applied, within what sensor and frame allow: first by time at the least gain,
// then by gain.
std::array<Exposure, ExposureSchedule::kMaxSlots> followed(std::span<const Exposure> cycle,
                                                           const ExposureAdvice& advice,
                                                           const ExposureLimits& limits);

}  // namespace hdrcam
