#include "firmware_host/run/budget_ladder.h"

#include <fmt/format.h>

#include <utility>

#include "hal/core/counted.h"

namespace hdrcam {
namespace {

// Few steps are halved, many are quartered: each rung shall save a time that is worth it.
int fewer(int steps) {
  constexpr int kFew = 4;
  return steps > kFew ? steps / 4 : steps / 2;
}

// The rungs so far. Each step adds those that give up one thing more, none where it is given up already.
class LadderSteps {
 public:
  explicit LadderSteps(const FrameBudget& asked)
      : rung_{.name = "as asked", .budget = asked}, ladder_{rung_} {}

  void leave_out_previews() {
    rung_.previews = false;
    add("no previews");
  }
  void fit_less() {
    int& steps = rung_.budget.fit.steps;
    while (steps > 1) {
      steps = fewer(steps);
      add(fmt::format("{} of the fit", counted(steps, "step")));
    }
  }
  void rest_field() {
    rung_.budget.field_rests = true;
    add("no field");
  }
  template <class Part>
  void lower(Part FrameBudget::*part, Part to, const char* name) {
    if (rung_.budget.*part <= to) return;
    rung_.budget.*part = to;
    add(name);
  }
  void lower_flow_over_clipped(FlowQuality quality, const char* name) {
    if (rung_.budget.flow > quality) lower(&FrameBudget::flow_over_clipped, quality, name);
  }
  void leave_out_blur() {
    if (!rung_.budget.blurs) return;
    rung_.budget.blurs = false;
    add("no motion blur");
  }
  void emit(int emitted, int of) {
    rung_.emitted = emitted, rung_.of = of;
    add(fmt::format("{} in {}", counted(emitted, "frame"), of));
  }

  std::vector<Rung> take() { return std::move(ladder_); }

 private:
  void add(std::string name) {
    rung_.name = std::move(name);
    ladder_.push_back(rung_);
  }

  Rung rung_;
  std::vector<Rung> ladder_;
};

}  // namespace

std::vector<Rung> budget_ladder(const FrameBudget& asked, FieldUse field, PreviewUse previews) {
  LadderSteps steps(asked);
  if (previews == PreviewUse::Some) steps.leave_out_previews();
  if (field != FieldUse::None) steps.fit_less();
  if (field == FieldUse::Fills) steps.rest_field();
  steps.lower(&FrameBudget::later_frames, 1, "one later frame");
  steps.lower(&FrameBudget::flow, FlowQuality::Medium, "flow medium");
  steps.lower(&FrameBudget::flow, FlowQuality::Fast, "flow fast");
  steps.lower_flow_over_clipped(FlowQuality::Coarse, "flow over clipped parts coarse");
  steps.lower(&FrameBudget::shrinkage, ShrinkageEffort::On, "fewer shrinkage tiles");
  steps.lower(&FrameBudget::later_frames, 0, "no look-ahead");
  steps.leave_out_blur();
  steps.lower(&FrameBudget::flow, FlowQuality::Coarse, "flow coarse");
  steps.lower(&FrameBudget::shrinkage, ShrinkageEffort::Off, "no shrinkage");
  steps.emit(3, 4);
  steps.emit(1, 2);
  return steps.take();
}

}  // namespace hdrcam
