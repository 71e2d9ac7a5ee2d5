// A wire between processor and simulated sensor: the trigger line drives it, the sensor strobes on it, a sync
// line sees either as edges. The wire is thread-safe, a line as sync_line.h states.
#pragma once

#include <array>
#include <atomic>
#include <functional>

#include "hal/sim/virtual_clock.h"
#include "hal/sync_line.h"

namespace hdrcam {

class SimulatedWire {
 public:
  explicit SimulatedWire(SimTime time) : time_(time) {}

  // Sets the level of the wire now and returns when; no edge if it does not change.
  Instant drive(bool active);
  // A pulse that begins and ends at known instants, perhaps in the near future: a strobe.
  void strobe(Instant begin, Duration width);
  bool level() const;
  // Calls `heard` with each driven edge, on the thread that drives it, from now on; one listener, or none.
  void listen(std::function<void(const Edge&)> heard);

 private:
  friend class SimulatedSyncLine;
  static constexpr std::size_t kEdges = SyncLine::kMostWaiting;  // history
  Edge add(Instant at, bool rising);

  const SimTime time_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::array<Edge, kEdges> edges_{};  // the n-th at n % kEdges
  std::uint64_t count_ = 0;
  bool level_ = false;
  std::mutex listening_;  // before mutex_ where both are taken
  std::function<void(const Edge&)> heard_;
};

class SimulatedSyncLine : public SyncLine {
 public:
  // The wire outlives the line, which sees the edges from now on.
  explicit SimulatedSyncLine(SimulatedWire& wire);

  Result<Edge> wait_edge(Duration timeout) override;
  void close() override;

 private:
  SimulatedWire& wire_;
  std::uint64_t first_, next_;  // edges of the wire: the first that this line saw, the next to hand out
  std::atomic<bool> closed_{false};
};

}  // namespace hdrcam
