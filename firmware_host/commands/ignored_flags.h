// Refuses a flag of the command line that its run would not use. What a file of settings holds is not
// refused: one file serves many runs. Reentrant.
#pragma once

#include "firmware_host/settings/settings_flags.h"
#include "hal/core/result.h"

namespace hdrcam {

// Errors: Invalid, naming the flags: those of a camera where a recording stands in for it, the pace of a
// recording where none does, those of the live page without --http, and those of EXR files, videos and pipes
// where the run writes none.
Result<void> check_ignored_flags(const SettingsFlags& flags, const Settings& settings);

// The same for a film of 8-bit pictures, which are as bright as an SDR display. Errors: Invalid, naming the
// flags of other displays.
Result<void> check_flags_on_display(const SettingsFlags& flags, const VideoOptions& options);

// The same for a film of a snapshot, whose scene is fitted. Errors: Invalid, naming the flags of a fit.
Result<void> check_flags_on_snapshot(const SettingsFlags& flags, const std::string& snapshot);

}  // namespace hdrcam
