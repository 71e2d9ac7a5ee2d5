#include "firmware_host/run/pipeline_options.h"

#include <fmt/format.h>

#include <map>
#include <string>

#include "capture/exposure_schedule.h"
#include "firmware_host/run/output_needs.h"
#include "firmware_host/settings/named_knobs.h"
#include "firmware_host/sinks/sink_name.h"
#include "hal/core/counted.h"

namespace hdrcam {
namespace {

bool shows_field(const Settings& settings, FieldUse use) {
  return use == FieldUse::Seen || settings.fit.emit == EmitLayer::Field ||
         needs_of(settings.output).shows_field();
}

// What a field gets that is itself seen, where nothing else is set by name.
void make_seen(Knobs& knobs, const std::map<std::string, std::string>& set_by_name) {
  FitBudget& budget = knobs.budget.fit;
  if (!set_by_name.contains("steps")) budget.steps = knobs.view_steps;
  if (!set_by_name.contains("fit_interval")) budget.interval = 1;
  if (knobs.field_step == FieldStep::Auto) knobs.field_step = FieldStep::One;
}

}  // namespace

PipelineOptions options_of(Preset preset, EmitLayer layer) {
  PipelineOptions options;
  options.knobs = knobs_of(preset);
  options.render.layer = layer;
  if (layer == EmitLayer::State) options.knobs.field = FieldKind::None;
  if (layer == EmitLayer::Field) make_seen(options.knobs, {});
  return options;
}

PipelineOptions options_of(const Settings& settings, FieldUse use) {
  const Settings::Fit& fit = settings.fit;
  PipelineOptions options = options_of(fit.preset, fit.emit);
  options.knobs.hash_grid.seed = static_cast<std::uint64_t>(fit.seed);
  const OutputNeeds needs = needs_of(settings.output);
  options.render.shows_flow_backward = needs.flow_backward;
  options.render.shows_flow_forward = needs.flow_forward;
  options.render.shows_field_flow = needs.field_flow;
  options.render.shows_points = needs.points;
  if (fit.readout == kOff)
    options.render.readout_s = 0;
  else if (!fit.readout.empty())
    options.render.readout_s = to_seconds(parse_duration(fit.readout).value());
  if (needs.depth)
    options.render.depth = DepthLayer::Whole;
  else if (!settings.output.path(sink_name::kSheet).empty())
    options.render.depth = DepthLayer::Glance;
  // a field that is to be seen, to be saved, or that poses are tracked beside, is there whatever the preset
  if ((shows_field(settings, use) || needs.scene || needs.poses) && fit.emit != EmitLayer::State)
    options.knobs.field = Knobs().field;
  set_named_knobs(options.knobs, fit);
  if (shows_field(settings, use)) make_seen(options.knobs, fit.knobs);
  if (needs.points && options.knobs.field_step == FieldStep::Auto) options.knobs.field_step = FieldStep::One;
  return options;
}

Result<void> check_readout(const Settings::Fit& fit, const CameraFacts& camera) {
  constexpr double kAlmost = 1.001;  // of the interval, which is rounded
  if (fit.readout.empty() || fit.readout == kOff) return {};
  if (camera.turned_upright)
    return Error{ErrorCode::Invalid,
                 fmt::format("--readout is of rows that are read out from top to bottom, and the pictures of "
                             "{} were turned when they were imported; leave it out",
                             called(camera))};
  if (!(camera.framerate_hz > 0)) return {};
  const Duration interval = from_seconds(1 / camera.framerate_hz),
                 asked = parse_duration(fit.readout).value();
  if (to_seconds(asked) <= kAlmost * to_seconds(interval)) return {};
  const std::string longest = describe(rounded_down(interval));
  return Error{
      ErrorCode::Invalid,
      fmt::format("--readout {} is longer than a frame, {} at {}, and rows are read out within one; give at "
                  "most {}, or leave it out",
                  fit.readout, longest, counted_per_second(camera.framerate_hz, "frame"), longest)};
}

FieldUse field_use(const Settings& settings, const PipelineOptions& options, FieldUse use) {
  if (options.knobs.field == FieldKind::None) return FieldUse::None;
  // poses before and after a rest of the field would be of two worlds
  const OutputNeeds needs = needs_of(settings.output);
  const bool stays = shows_field(settings, use) || needs.scene || needs.poses;
  return stays ? FieldUse::Seen : FieldUse::Fills;
}

}  // namespace hdrcam
