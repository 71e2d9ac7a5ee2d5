// The values of the knobs in each preset.
#include "online/knobs.h"

namespace hdrcam {

const char* name(Preset preset) {
  switch (preset) {
    case Preset::Realtime:
      return "realtime";
    case Preset::Fast:
      return "fast";
    case Preset::Balanced:
      return "balanced";
    case Preset::Best:
      return "best";
  }
  return "?";
}

Knobs knobs_of(Preset preset) {
  Knobs knobs;
  FitBudget& fit = knobs.budget.fit;
  switch (preset) {
    case Preset::Realtime:
      knobs = knobs_of(Preset::Fast);
      knobs.budget.flow = FlowQuality::Fast;
      knobs.budget.shrinkage = ShrinkageEffort::On;
      knobs.field = FieldKind::None;
      break;
    case Preset::Fast:
      knobs.budget.render_step = 4;
      fit.steps = 1, fit.interval = 4, fit.samples_per_ray = 6, fit.samples_without_parallax = 1;
      knobs.view_steps = 10;
      knobs.hash_grid.shape.static_grid.log2_entries = 14;
      knobs.hash_grid.shape.dynamic_grid.log2_entries = 12;
      break;
    case Preset::Balanced:
      knobs.budget.flow = FlowQuality::Fine;
      knobs.look_ahead = Knobs::kAsSizeAllows;
      fit.steps = 1, fit.interval = 4;
      break;
    case Preset::Best:
      knobs.budget.flow = FlowQuality::Fine;
      knobs.budget.render_step = 1;
      knobs.look_ahead = 2;
      fit.steps = 1, fit.interval = 2;
      knobs.view_steps = 100;
      break;
  }
  return knobs;
}

int look_ahead_of(const Knobs& knobs, int rows, int cols) {
  constexpr std::int64_t kSmall = 640 * 480;  // pixels
  if (knobs.look_ahead != Knobs::kAsSizeAllows) return knobs.look_ahead;
  return static_cast<std::int64_t>(rows) * cols <= kSmall ? 2 : 1;
}

}  // namespace hdrcam
