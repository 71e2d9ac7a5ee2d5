// The deadline per frame that a run holds: the setting, or the interval of a camera that does not wait.
// Reentrant.
#pragma once

#include <optional>

#include "firmware_host/run_pace.h"
#include "firmware_host/settings/settings.h"
#include "hal/core/frame.h"

namespace hdrcam {

// None: the run takes the time that it needs. The text of the setting was checked when it was read.
std::optional<Duration> deadline_of(const Settings::Fit& fit, const CameraFacts& camera, RunPace pace);

// Whether a run that keeps up with the camera needs no more than this deadline: then a queue tells whether it
// holds it. A shorter one is asked for its own sake.
bool is_pace_of(const CameraFacts& camera, Duration deadline);

}  // namespace hdrcam
