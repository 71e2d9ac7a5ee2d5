// What may be asked of a camera's exposures: the cycle that runs, and the limits that sensor, frame and mains
// set to another one. The camera side states it once; the answer is a cycle of as many exposures. Plain
// value.
#pragma once

#include <vector>

#include "capture/exposure_schedule.h"

namespace hdrcam {

// What the cycle follows while it runs: nothing, the light (exposure_adaptation.h), or the error that the fit
// expects of it, blur included (online/exposure/cycle_choice.h).
enum class Adapt { Off, Light, Motion };

struct ExposureLimits {
  std::vector<Exposure> cycle;               // as it ran at the start: rounded to what the sensor can do
  Duration shortest{0}, longest{0};          // exposure times, within a frame
  double least_gain = 1, greatest_gain = 1;  // analogue; equal where all exposures must have one gain
  Mains mains = Mains::Off;
};

}  // namespace hdrcam
