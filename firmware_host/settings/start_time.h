// The time of a run's start in the names of its files, so that a service that is started again writes new
// ones. Reentrant.
#pragma once

#include <chrono>
#include <string>

#include "firmware_host/settings/settings.h"

namespace hdrcam {

// Replaces each "{start}" in the names of recordings, outputs and the trace: "take-{start}.mkv" becomes
// "take-20261122T143005Z.mkv", in UTC.
Settings with_start_time(Settings settings, std::chrono::system_clock::time_point start);
// The same of one name, of an output that is no setting: the run starts now.
std::string named_at_start(const std::string& name);

}  // namespace hdrcam
