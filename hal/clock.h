// Time. The program uses one clock, the boot clock (Instant); timestamps of other clocks are converted here,
// with measured offsets. Real and virtual (sim/). Thread-safe.
#pragma once

#include <chrono>

#include "hal/core/instant.h"

namespace hdrcam {

enum class ClockDomain { Boot, Monotonic, Realtime };

class Clock {
 public:
  virtual ~Clock() = default;
  virtual Instant now() = 0;
  virtual void sleep_until(Instant when) = 0;
  // A timestamp of another clock, taken within the last seconds, as an Instant.
  virtual Instant instant_of(ClockDomain domain, Duration timestamp) = 0;
  // For file names and dates only.
  virtual std::chrono::system_clock::time_point wall_time() = 0;
};

// The clocks of this machine.
Clock& posix_clock();

}  // namespace hdrcam
