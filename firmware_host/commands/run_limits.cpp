#include "firmware_host/commands/run_limits.h"

#include <CLI/CLI.hpp>

namespace hdrcam {

void add_run_limits(CLI::App& verb, std::uint64_t& frames, double& timeout_s) {
  verb.add_option("--frames", frames, "stop after so many frames [until ^C]")->check(CLI::PositiveNumber);
  verb.add_option("--timeout", timeout_s, "stop after so many seconds [until ^C]")
      ->check(CLI::PositiveNumber);
}

Result<void> ended_by(LiveEnd end, bool limited, std::uint64_t captured) {
  if (end != LiveEnd::Stopped || !limited) return {};
  return Error{ErrorCode::Interrupted, fmt::format("stopped after {} frames; they are complete", captured)};
}

}  // namespace hdrcam
