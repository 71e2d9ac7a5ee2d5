// Measures on this machine what each effect costs: the processor time of a frame, all threads together, while
// the effects of the plan are added one after the other, in the order in which light meets them. So the costs
// add up to the frame. In a static scene light is computed once, and effects on light cost nothing after the
// first frame. Thread-bound.
#pragma once

#include "hal/sim/simulated_sensor.h"

namespace hdrcam {

struct EffectCosts {
  double bare_ms = 0;   // without the optional effects
  double frame_ms = 0;  // with all effects of the plan
  double noise_ms = 0;  // difference of two measurements of the same frame
  // For each effect that is on, changes pixels and is optional: what it adds to those before it. Negative
  // values are noise.
  std::array<std::optional<double>, kEffects> effect_ms;
};

// exposure_s: of the measured frames. The variants are measured in turn, at least twice each, until two
// measurements of each agree to 1 % or `patience` is over; the shortest times count.
EffectCosts measure_costs(const Simulation& simulation, PixelLayout layout, int bits, double exposure_s,
                          Duration patience, WorkerPool& pool);

}  // namespace hdrcam
