// What each effect costs, measured on this machine by leaving it out: the processor time of a frame, all
// threads together, with all effects of the plan, minus the time without that one.
#pragma once

#include "hal/sim/simulated_sensor.h"

namespace hdrcam {

struct EffectCosts {
  double frame_ms = 0;  // with all effects of the plan
  double bare_ms = 0;   // with none that can be left out
  std::array<std::optional<double>, kEffects>
      effect_ms;  // of those that are on and touch pixels and can be left out
};

// exposure_s: of the frames that are measured; the shortest time of `rounds` counts.
EffectCosts measure_costs(const Simulation& simulation, PixelLayout layout, int bits, double exposure_s,
                          int rounds, WorkerPool& pool);

}  // namespace hdrcam
