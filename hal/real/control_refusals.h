// What becomes of an exposure that a device did not take. A USB camera fails a control transfer now and then
// (a stall, a bus error, "not ready") and takes the next one: its frame goes without its exposure, which the
// ControlPacer tells, and the run goes on. One that takes none for a second ends it, with what to do about
// it. Thread-compatible.
#pragma once

#include <chrono>
#include <cstdint>

#include "hal/core/instant.h"
#include "hal/core/result.h"

namespace hdrcam {

class ControlRefusals {
 public:
  // A run ends at a refusal that is so long after the first in a row, and of so many frames: of a slow
  // camera, or where each times out, a second has only one.
  static constexpr Duration kLongest = std::chrono::seconds(1);
  static constexpr int kFewest = 3;  // frames

  void restart() { *this = {}; }

  // What the device answered, just now, to the exposure of the frame with this index. Its error, where it
  // will not pass or went on for too long.
  Result<void> answered(std::uint64_t frame, const Result<void>& wrote, Instant now);

 private:
  int frames_ = 0;          // in a row
  std::uint64_t last_ = 0;  // of them
  Instant begun_;           // the first one
};

}  // namespace hdrcam
