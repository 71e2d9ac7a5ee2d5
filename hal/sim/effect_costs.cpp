#include "hal/sim/effect_costs.h"

#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <vector>

namespace hdrcam {
namespace {

bool can_be_left_out(Effect effect) {
  switch (effect) {
    case Effect::Mosaic:
    case Effect::Quantisation:  // the codes would not be codes
    case Effect::ControlDelay:
    case Effect::Drops:
    case Effect::ClockJitter:
      return false;  // no pixel depends on them
    default:
      return true;
  }
}

// A frame with the effects up to and including one.
struct Step {
  std::optional<Effect> effect;
  SimulatedSensor sensor;
  double best_ms = std::numeric_limits<double>::infinity();
};

void time_one(Step& step, const Shot& shot, Image<std::uint16_t>& codes) {
  const std::clock_t begin = std::clock();
  step.sensor.expose(shot, codes);
  const double took_ms = static_cast<double>(std::clock() - begin) * 1e3 / CLOCKS_PER_SEC;
  step.best_ms = std::min(step.best_ms, took_ms);
}

}  // namespace

EffectCosts measure_costs(const Simulation& simulation, PixelLayout layout, int bits, double exposure_s,
                          Duration patience, WorkerPool& pool) {
  Step whole{{}, SimulatedSensor(simulation, layout, bits, pool)};
  const EffectPlan plan = whole.sensor.simulation().plan;
  Simulation so_far = whole.sensor.simulation();
  for (std::size_t i = 0; i < kEffects; ++i)
    if (can_be_left_out(static_cast<Effect>(i))) so_far.plan.switch_off(static_cast<Effect>(i), "measured");
  std::vector<Step> steps;
  const auto add = [&](std::optional<Effect> effect) {
    steps.push_back({effect, SimulatedSensor(so_far, layout, bits, pool, whole.sensor.scene())});
  };
  add({});
  for (std::size_t i = 0; i < kEffects; ++i) {
    const auto effect = static_cast<Effect>(i);
    if (!plan.on(effect) || !can_be_left_out(effect)) continue;
    so_far.plan.switch_on(effect, "measured");
    add(effect);
  }

  Image<std::uint16_t> codes;
  const auto apart_ms = [&] { return std::abs(whole.best_ms - steps.back().best_ms); };
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t round = 0; round < 2 || (apart_ms() > 0.01 * whole.best_ms &&
                                              std::chrono::steady_clock::now() - begin < patience);
       ++round) {  // in turn, so that a machine that slows down affects all variants alike
    const Shot shot{round, 0.5, exposure_s, 1};
    for (Step& step : steps) time_one(step, shot, codes);
    time_one(whole, shot, codes);
  }

  EffectCosts costs;
  costs.bare_ms = steps.front().best_ms;
  costs.frame_ms = steps.back().best_ms;
  costs.noise_ms = apart_ms();
  for (std::size_t i = 1; i < steps.size(); ++i)
    costs.effect_ms[static_cast<std::size_t>(*steps[i].effect)] = steps[i].best_ms - steps[i - 1].best_ms;
  return costs;
}

}  // namespace hdrcam
