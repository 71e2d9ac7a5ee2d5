#include "hal/sim/effect_costs.h"

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

struct Candidate {
  std::optional<Effect> left_out;
  std::unique_ptr<SimulatedSensor> sensor;
  double best_ms = std::numeric_limits<double>::infinity();
};

void time_one(Candidate& candidate, const Shot& shot, Image<std::uint16_t>& codes) {
  const std::clock_t begin = std::clock();
  candidate.sensor->expose(shot, codes);
  const double took_ms = static_cast<double>(std::clock() - begin) * 1e3 / CLOCKS_PER_SEC;
  candidate.best_ms = std::min(candidate.best_ms, took_ms);
}

}  // namespace

EffectCosts measure_costs(const Simulation& simulation, PixelLayout layout, int bits, double exposure_s,
                          int rounds, WorkerPool& pool) {
  std::vector<Candidate> candidates;
  candidates.push_back({{}, std::make_unique<SimulatedSensor>(simulation, layout, bits, pool)});
  const Simulation whole = candidates.front().sensor->simulation();
  const auto scene = candidates.front().sensor->scene();
  const auto add = [&](std::optional<Effect> left_out, const Simulation& s) {
    candidates.push_back({left_out, std::make_unique<SimulatedSensor>(s, layout, bits, pool, scene)});
  };
  Simulation bare = whole;
  for (std::size_t i = 0; i < kEffects; ++i) {
    const auto effect = static_cast<Effect>(i);
    if (!whole.plan.on(effect) || !can_be_left_out(effect)) continue;
    Simulation without = whole;
    without.plan.switch_off(effect, "measured");
    bare.plan.switch_off(effect, "measured");
    add(effect, without);
  }
  add(std::nullopt, bare);

  Image<std::uint16_t> codes;
  for (int round = 0; round < rounds;
       ++round)  // interleaved, so that a machine that slows down is unfair to nobody
    for (Candidate& candidate : candidates)
      time_one(candidate, {static_cast<std::uint64_t>(round), 0.5, exposure_s, 1}, codes);

  EffectCosts costs;
  costs.frame_ms = candidates.front().best_ms;
  costs.bare_ms = candidates.back().best_ms;
  for (const Candidate& candidate : candidates)
    if (candidate.left_out)
      costs.effect_ms[static_cast<std::size_t>(*candidate.left_out)] =
          std::max(0.0, costs.frame_ms - candidate.best_ms);
  return costs;
}

}  // namespace hdrcam
