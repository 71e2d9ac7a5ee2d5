// A machine of known costs for the governor: nothing measures a time.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <vector>

#include "firmware_host/run/governor.h"
#include "online/knobs.h"
#include "tests/support/moving_scene.h"

namespace hdrcam::test {

constexpr Duration kDeadline = std::chrono::microseconds(33333);
// What a frame takes: 26.6 ms as asked where nothing else runs, 10 ms on the cheapest rung that emits.
struct Machine {
  double load = 1;      // on every stage
  double noise = 0;     // sigma of ln time, of each stage
  int spike_every = 0;  // frames; a spike takes three times as long
  double third = 1;     // how much longer every third frame takes, as one whose long exposure is clipped
  std::uint64_t draws = 0;
  int frames = 0;

  double jitter() { return std::exp(noise * test::MovingScene::noise(1000 + 12 * draws++)); }

  FrameWork work(const FrameBudget& budget, bool previews) {
    FrameWork work{.frames = 1};
    const int frame = frames++;
    const bool spike = spike_every > 0 && frame % spike_every == spike_every / 2;
    const double slow = load * (previews ? 1.05 : 1) * (spike ? 3 : 1) * (frame % 3 == 0 ? third : 1);
    work.steady_ms = slow * 5 * jitter();
    const double motion_ms[] = {3, 3.2, 4.2, 6.4};  // coarse, fast, medium, fine
    const double shrinkage_ms[] = {0, 1.3, 2};      // off, on, dense
    work.total_ms = work.steady_ms + slow * motion_ms[static_cast<int>(budget.flow)] * jitter();
    const bool over_clipped = std::min(budget.flow, budget.flow_over_clipped) > FlowQuality::Coarse;
    if (over_clipped) work.total_ms += slow * 0.6 * jitter();
    if (budget.blurs) work.total_ms += slow * jitter();
    if (!budget.field_rests) work.total_ms += slow * (5 + 1.2 * budget.fit.steps) * jitter();
    if (budget.emits)
      work.total_ms += slow *
                       (2 + 0.5 * budget.later_frames + shrinkage_ms[static_cast<int>(budget.shrinkage)]) *
                       jitter();
    return work;
  }
};

inline std::vector<Rung> ladder() {
  FrameBudget asked = knobs_of(Preset::Balanced).budget;
  asked.fit.steps = 2;
  return budget_ladder(asked, FieldUse::Fills, PreviewUse::Some);
}

}  // namespace hdrcam::test
