// What `live` and `record` share: the checks before a camera is opened, and what of the settings holds where
// a recording stands in for it. Reentrant.
#pragma once

#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/run_limits.h"
#include "firmware_host/run/recording_source.h"
#include "firmware_host/settings/settings.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// The cycle, outputs and lines. recording_flag: the verb's flag for the recording, "--record". Errors: those
// of check_recording_name, parse_exposures, KeptWork::check and check_lines.
Result<void> check_camera_run(const Settings& settings, const char* recording_flag, const KeptWork& kept,
                              Storage& storage);

// Whether the camera is a recording that is read as fast as it is worked on.
bool is_read_as_fast_as_asked(const Settings::Camera& camera);
// Of such a recording; the one that the settings name for the camera's frames becomes its copy.
RecordingSourceOptions recording_options(const Settings& settings, const RunLimits& limits);

}  // namespace hdrcam
