// From settings to what the pipeline is made with: the knobs of the method and what is rendered. Reentrant.
#pragma once

#include "firmware_host/run/budget_ladder.h"
#include "firmware_host/settings/settings.h"
#include "online/knobs.h"
#include "render/render_stage.h"

namespace hdrcam {

struct PipelineOptions {
  Knobs knobs;
  RenderOptions render;
};
// The knobs of a preset for one layer: the state alone needs no field.
PipelineOptions options_of(Preset preset, EmitLayer layer);
// use: Fills or Seen, beside what the settings show of the field. A field that is seen takes more steps.
PipelineOptions options_of(const Settings& settings, FieldUse use);
// Invalid where the settings have the rows read out for longer than a frame of the camera, or where its rows
// are not those of the sensor.
Result<void> check_readout(const Settings::Fit& fit, const CameraFacts& camera);
// What a run with these settings and options has the field for.
FieldUse field_use(const Settings& settings, const PipelineOptions& options, FieldUse use);

}  // namespace hdrcam
