#include "hal/sim/stream_effects.h"

namespace hdrcam {

StreamEffects::StreamEffects(const Simulation& simulation) {
  const std::uint64_t seed = simulation.scene.seed;
  if (simulation.plan.on(Effect::Drops)) drops_.emplace(simulation.drops, seed);
  if (simulation.plan.on(Effect::ClockJitter)) jitter_.emplace(simulation.clock_jitter, seed);
}

}  // namespace hdrcam
