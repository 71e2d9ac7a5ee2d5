// A GPIO line between sensor and processor: trigger pulses out (FSYNC; the pulse width is the exposure on
// sensors with an external shutter), strobe edges in with the kernel's timestamps. Real (libgpiod),
// simulated, replayed, faulty. Thread-bound, except close(), which any thread may call to end a wait.
#pragma once

#include <cstdint>

#include "hal/core/instant.h"
#include "hal/core/result.h"

namespace hdrcam {

enum class LineDirection { Input, Output };

struct SyncLineCapabilities {
  bool output = false;  // drives pulses
  bool input = false;   // sees edges
};

struct Edge {
  Instant at;  // taken by the kernel in its interrupt handler
  bool rising = true;
  std::uint64_t sequence = 0;  // counts edges; a gap is a lost event
};

class SyncLine {
 public:
  virtual ~SyncLine() = default;
  virtual SyncLineCapabilities capabilities() const = 0;
  // Drives the line active for `width`, then inactive. Unsupported on an input.
  virtual Result<void> pulse(Duration width) = 0;
  // The next edge. Timeout, Unplugged, Interrupted. Unsupported on an output.
  virtual Result<Edge> wait_edge(Duration timeout) = 0;
  virtual void close() = 0;
};

}  // namespace hdrcam
