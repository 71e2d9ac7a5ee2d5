// The limits of a run on a camera, and the result at its end. Reentrant.
#pragma once

#include <cstdint>

#include "firmware_host/command_line.h"
#include "firmware_host/live/live_session.h"

namespace hdrcam {

// What --frames takes: a number of frames.
WordCheck counts_frames();

struct RunLimits {
  std::uint64_t frames = 0;  // 0: until ^C
  double timeout_s = 0;      // 0: until ^C

  // The flags --frames and --timeout.
  void add_to(CommandLine verb);
  LiveOptions options(LiveWork work) const;
  // ^C is the normal end of a run without limits; a run with limits is then Interrupted. Timeout where the
  // time was up before the first frame.
  Result<void> ended_by(LiveEnd end, std::uint64_t captured) const;
};

}  // namespace hdrcam
