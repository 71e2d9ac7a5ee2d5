// What each effect costs, measured on this machine: the processor time of a frame, all threads together, as
// the effects of the plan are added one after the other, in the order in which light meets them. So the costs
// add up to the frame. Where nothing moves, light falls once, and what works on light costs nothing after the
// first frame.
#pragma once

#include "hal/sim/simulated_sensor.h"

namespace hdrcam {

struct EffectCosts {
  double bare_ms = 0;   // with no effect that can be left out
  double frame_ms = 0;  // with all of the plan
  double noise_ms = 0;  // how far two measurements of the same frame lie apart
  // Of those that are on, touch pixels and can be left out: what each adds to those before it. Below zero
  // only by noise.
  std::array<std::optional<double>, kEffects> effect_ms;
};

// exposure_s: of the frames that are measured. Each kind is exposed in turn, at least twice, until two
// measurements of the same kind agree to 1 % or `patience` is over; the shortest times count.
EffectCosts measure_costs(const Simulation& simulation, PixelLayout layout, int bits, double exposure_s,
                          Duration patience, WorkerPool& pool);

}  // namespace hdrcam
