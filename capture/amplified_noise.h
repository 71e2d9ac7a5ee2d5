// The noise of the same sensor with its signal amplified: relative exposure 1 is reached by fewer electrons,
// so shot and read noise weigh more (noise_model.h). Reentrant.
#pragma once

#include "capture/noise_model.h"

namespace hdrcam {

// gain: over that at which `noise` holds.
inline NoiseModel amplified(const NoiseModel& noise, float gain) {
  NoiseModel more = noise;
  more.full_well = noise.full_well / gain;
  return more;
}

}  // namespace hdrcam
