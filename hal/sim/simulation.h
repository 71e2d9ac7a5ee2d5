// All settings of a simulated camera, and the text that names it: `walk?seed=3&size=320x240&objects=5`, a
// scene of the catalogue and, after a question mark, settings that differ from the scene's defaults. Value
// type, reentrant.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "hal/camera.h"
#include "hal/core/result.h"
#include "hal/sim/effects/clock_jitter.h"
#include "hal/sim/effects/distortion.h"
#include "hal/sim/effects/drops.h"
#include "hal/sim/effects/flare.h"
#include "hal/sim/effects/hot_pixels.h"
#include "hal/sim/effects/mains_flicker.h"
#include "hal/sim/effects/motion_blur.h"
#include "hal/sim/effects/noise.h"
#include "hal/sim/effects/response_curve.h"
#include "hal/sim/effects/rolling_shutter.h"
#include "hal/sim/effects/vignetting.h"
#include "hal/sim/renderer.h"
#include "hal/sim/scene_catalog.h"

namespace hdrcam {

constexpr int kLeastSimulated_px = 16, kMostSimulated_px = 4096;  // sides of a picture

struct Simulation {
  SceneSettings scene;
  int width = 320, height = 240;  // pixels
  double framerate_hz = 30;
  double view_deg = 55;              // horizontal field of view
  double sensitivity_per_s = 167.5;  // relative exposure = radiance * seconds * gain * this; 1 saturates
  float full_well_e = 6000;          // electrons at relative exposure 1, gain 1
  float black_level = 0;             // share of the code range, 0..0.2
  bool reports_exposure = true;      // with each buffer, as embedded data
  Sampling sampling = Sampling::Smooth;
  EffectPlan plan;

  MotionBlurSettings motion_blur;
  RollingShutterSettings rolling_shutter;
  DistortionSettings distortion;
  VignettingSettings vignetting;
  FlareSettings flare;
  MainsFlickerSettings mains_flicker;
  HotPixelSettings hot_pixels;
  NoiseSettings noise;
  CurveShape response = CurveShape::Film;
  ControlDelays control_delay{2, 1};  // frames
  DropSettings drops;
  ClockJitterSettings clock_jitter;

  // As a buffer states it, at most a frame: a sensor reads one after the other. 0 where all rows are exposed
  // at once.
  Duration readout() const {
    return plan.on(Effect::RollingShutter) ? std::min(rolling_shutter.readout, frame_duration())
                                           : Duration::zero();
  }
  Duration frame_duration() const { return Duration(static_cast<Duration::rep>(1e9 / framerate_hz + 0.5)); }
};

// Errors: NotFound for a scene that is not in the catalogue, Invalid for a setting; the message lists the
// choices.
Result<Simulation> simulation_of(std::string_view text);

// The settings, one per line, with unit, range and meaning.
std::string simulation_settings_help();

}  // namespace hdrcam
