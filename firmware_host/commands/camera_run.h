// What `live` and `record` share: their settings, the checks before a camera is opened, the camera, its
// account at the end, and what of it holds where a recording stands in for the camera. Thread-bound.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/run_limits.h"
#include "firmware_host/commands/trace_file.h"
#include "firmware_host/live/camera_source.h"
#include "firmware_host/run/recording_source.h"
#include "firmware_host/settings/settings_flags.h"
#include "firmware_host/sinks/sink_table.h"

namespace hdrcam {

// The settings with the time of this start in the names of files. Errors: those of check_ignored_flags.
Result<Settings> started_settings(const SettingsFlags& flags, const Settings& asked);

// A recording that stands in for the camera has a name and is no snapshot of a scene. Errors: Invalid without
// a name; those of check_no_snapshot.
Result<void> check_replayed(const Settings::Camera& camera, Storage& storage);

// The camera, cycle, outputs and lines. recording_flag: the verb's flag for the recording, "--record"; sinks:
// those of the verb. Errors: those of check_recording_name, check_replayed, parse_exposures, KeptWork::check
// and check_lines.
Result<void> check_camera_run(const Settings& settings, const char* recording_flag,
                              std::span<const SinkKind> sinks, const KeptWork& kept, Storage& storage);

// Opens the camera and shows what the user should know of it. trace: outlives the camera. Errors: those of
// CameraSource::open.
Result<std::unique_ptr<CameraSource>> open_camera_source(const Settings& settings, LiveOptions limits,
                                                         TraceFile& trace, Surroundings& around);
// At the end of the run: what became of the captured frames, how their exposures were proved, and what the
// cycle, the trigger and the strobe line did meanwhile; lines for the user.
std::string account_of(CameraSource& camera);
// What the camera says of its frames, at the end of the run: those of a recording that were damaged. And what
// makes the pictures contradict many exposures.
void show_warnings(CameraSource& camera, const Settings& settings);

// Whether the camera is a recording that is read as fast as it is worked on.
bool is_read_as_fast_as_asked(const Settings::Camera& camera);
// Opens such a recording; the one that the settings name for the camera's frames becomes its copy. Errors:
// those of RecordingSource::open.
Result<std::unique_ptr<RecordingSource>> open_replayed(const Settings& settings, const RunLimits& limits,
                                                       Contradiction contradiction, Surroundings& around);

}  // namespace hdrcam
