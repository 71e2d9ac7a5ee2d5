// A wire with GPIO lines on it: an input sees the pulses of an output and the strobes of a simulated sensor
// as edges. The wire is thread-safe, a line as sync_line.h states.
#pragma once

#include <array>
#include <atomic>

#include "hal/sim/virtual_clock.h"
#include "hal/sync_line.h"

namespace hdrcam {

class SimulatedWire {
 public:
  explicit SimulatedWire(SimTime time) : time_(time) {}

  // Sets the level of the wire now; no edge if it does not change.
  void drive(bool active);
  // A pulse that begins and ends at known instants, perhaps in the near future: a strobe.
  void strobe(Instant begin, Duration width);
  bool level() const;

 private:
  friend class SimulatedSyncLine;
  static constexpr std::size_t kEdges = 256;  // history; a reader that is further behind loses the oldest
  void add(Instant at, bool rising);

  const SimTime time_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::array<Edge, kEdges> edges_{};  // the n-th at n % kEdges
  std::uint64_t count_ = 0;
  bool level_ = false;
};

class SimulatedSyncLine : public SyncLine {
 public:
  // The wire outlives the line. An input sees the edges from now on.
  SimulatedSyncLine(SimulatedWire& wire, LineDirection direction);

  SyncLineCapabilities capabilities() const override;
  Result<void> pulse(Duration width) override;
  Result<Edge> wait_edge(Duration timeout) override;
  void close() override;

 private:
  SimulatedWire& wire_;
  LineDirection direction_;
  std::uint64_t first_, next_;  // edges of the wire: the first that this line saw, the next to hand out
  std::atomic<bool> closed_{false};
};

}  // namespace hdrcam
