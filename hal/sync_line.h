// The GPIO line on which a sensor answers: its strobe edges come in with the kernel's timestamps. Real
// (libgpiod), simulated, faulty. Thread-bound, except close(), which any thread may call to end a wait. The
// line that drives a sensor is hal/trigger_line.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "hal/core/instant.h"
#include "hal/core/result.h"

namespace hdrcam {

struct Edge {
  Instant at;  // taken by the kernel in its interrupt handler
  bool rising = true;
  std::uint64_t sequence = 0;  // counts edges; a gap is a lost event
};

class SyncLine {
 public:
  // Edges that a line keeps at most for a reader that is late; then it loses the oldest.
  static constexpr std::size_t kMostWaiting = 256;

  virtual ~SyncLine() = default;
  // The next edge. Timeout, Unplugged, Interrupted.
  virtual Result<Edge> wait_edge(Duration timeout) = 0;
  virtual void close() = 0;
};

}  // namespace hdrcam
