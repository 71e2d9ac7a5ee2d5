// How long a run on a camera lasts, and how it says that it ended. Reentrant.
#pragma once

#include <cstdint>

#include "firmware_host/live/live_session.h"

namespace CLI {
class App;
}

namespace hdrcam {

// The flags --frames and --timeout.
void add_run_limits(CLI::App& verb, std::uint64_t& frames, double& timeout_s);

// ^C is how a run without limits ends; one that was to go on is Interrupted.
Result<void> ended_by(LiveEnd end, bool limited, std::uint64_t captured);

}  // namespace hdrcam
