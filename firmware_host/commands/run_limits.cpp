#include "firmware_host/commands/run_limits.h"

#include <CLI/CLI.hpp>

namespace hdrcam {

void RunLimits::add_to(CLI::App& verb) {
  verb.add_option("--frames", frames, "frames to capture [until ^C]")->check(CLI::PositiveNumber);
  verb.add_option("--timeout", timeout_s, "duration in seconds [until ^C]")->check(CLI::PositiveNumber);
}

LiveOptions RunLimits::options(bool fits) const {
  return {.frames = frames, .timeout = Instant::from_seconds(timeout_s).since_boot, .fits = fits};
}

Result<void> RunLimits::ended_by(LiveEnd end, std::uint64_t captured) const {
  const bool limited = frames > 0 || timeout_s > 0;
  if (end != LiveEnd::Stopped || !limited) return {};
  return Error{ErrorCode::Interrupted, fmt::format("stopped after {} frames; they are complete", captured)};
}

}  // namespace hdrcam
