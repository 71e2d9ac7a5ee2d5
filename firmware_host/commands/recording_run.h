// A run on a recording, as `replay`, `render` and `live --camera replay:FILE` share it. Thread-bound.
#pragma once

#include <string>
#include <vector>

#include "firmware_host/commands/command.h"
#include "firmware_host/run/budget_ladder.h"
#include "firmware_host/run/recording_source.h"
#include "firmware_host/run/run.h"
#include "firmware_host/settings/settings.h"
#include "firmware_host/settings/settings_flags.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// The settings that apply to `replay` and `render`.
inline const std::vector<SettingGroup> kRecordingRunGroups{SettingGroup::Fit, SettingGroup::Knobs,
                                                           SettingGroup::Output, SettingGroup::Machine};

// Before an output's folder is made. verb: "replay". Errors: Invalid where no recording is named, NotFound
// where there is none of that name.
Result<void> check_recording_named(Storage& storage, const std::string& recording, const char* verb);
// The settings of such a run: with the time of its start in the names of files, and without recordings that
// the live page starts, which a file of settings may have. Errors: those of check_ignored_flags.
Result<Settings> settings_on_recording(const SettingsFlags& flags, const Settings& asked);
// Whether any output besides a recording is asked for.
bool writes_outputs(const Settings::Output& output);

// Before an output's folder is made and the fit begins: poses that are to be written are there or tracked,
// and given ones need their lens. Errors: those of check_lens and check_tracked_poses.
Result<void> check_recorded_poses(const std::string& recording, const Settings& settings,
                                  Surroundings& around);

// Errors: Unsupported where the pictures need more memory than the settings allow.
Result<void> admit_fit(const Settings& settings, const CameraFacts& clip, FieldUse use = FieldUse::Fills);

// The clip's own name, else that of its file.
std::string title_of(const CameraFacts& clip, const std::string& file);

// Runs the plan, writes the trace that its settings ask for, and shows the warnings about the recording.
// Errors: those of run(), else of the disk.
Result<void> run_on(RecordingSource& source, RunPlan plan, Storage& storage);
void show_warnings(const RecordingSource& source);

}  // namespace hdrcam
