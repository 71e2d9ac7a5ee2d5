#include "firmware_host/run/budget_ladder.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/core/counted.h"

namespace hdrcam {
namespace {

// Few steps are halved, many are quartered: each rung shall save a time that is worth it.
int fewer(int steps) {
  constexpr int kFew = 4;
  return steps > kFew ? steps / 4 : steps / 2;
}

}  // namespace

std::vector<Rung> budget_ladder(const FrameBudget& asked, FieldUse field, PreviewUse previews) {
  std::vector<Rung> ladder{{.name = "as asked", .budget = asked}};
  Rung rung = ladder.front();
  const auto add = [&](std::string name) {
    rung.name = std::move(name);
    ladder.push_back(rung);
  };
  if (previews == PreviewUse::Some) {
    rung.previews = false;
    add("no previews");
  }
  if (field != FieldUse::None) {
    int& steps = rung.budget.fit.steps;
    while (steps > 1) {
      steps = fewer(steps);
      add(fmt::format("{} of the fit", counted(steps, "step")));
    }
  }
  if (field == FieldUse::Fills) {
    rung.budget.field_rests = true;
    add("no field");
  }
  if (rung.budget.later_frames > 1) {
    rung.budget.later_frames = 1;
    add("one later frame");
  }
  const auto lower_flow = [&](FlowQuality quality, const char* name) {
    if (rung.budget.flow <= quality) return;
    rung.budget.flow = quality;
    add(name);
  };
  lower_flow(FlowQuality::Medium, "flow medium");
  lower_flow(FlowQuality::Fast, "flow fast");
  if (std::min(rung.budget.flow, rung.budget.flow_over_clipped) > FlowQuality::Coarse) {
    rung.budget.flow_over_clipped = FlowQuality::Coarse;
    add("flow over clipped parts coarse");
  }
  if (rung.budget.shrinkage == ShrinkageEffort::Dense) {
    rung.budget.shrinkage = ShrinkageEffort::On;
    add("fewer shrinkage tiles");
  }
  if (rung.budget.later_frames > 0) {
    rung.budget.later_frames = 0;
    add("no look-ahead");
  }
  if (rung.budget.blurs) {
    rung.budget.blurs = false;
    add("no motion blur");
  }
  lower_flow(FlowQuality::Coarse, "flow coarse");
  if (rung.budget.shrinkage != ShrinkageEffort::Off) {
    rung.budget.shrinkage = ShrinkageEffort::Off;
    add("no shrinkage");
  }
  for (const auto& [emitted, of] : {std::pair(3, 4), {1, 2}}) {
    rung.emitted = emitted, rung.of = of;
    add(fmt::format("{} in {}", counted(emitted, "frame"), of));
  }
  return ladder;
}

}  // namespace hdrcam
