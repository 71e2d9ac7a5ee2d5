#include "hal/sim/simulated_sync_line.h"

#include <algorithm>

namespace hdrcam {
namespace {

const Error kClosed{ErrorCode::Interrupted, "the simulated line was closed"};

}  // namespace

Edge SimulatedWire::add(Instant at, bool rising) {
  const Edge edge{at, rising, count_};
  edges_[count_++ % kEdges] = edge;
  level_ = rising;
  return edge;
}

Instant SimulatedWire::drive(bool active) {
  const std::lock_guard one_at_a_time(listening_);
  Edge edge;
  {
    const std::lock_guard lock(mutex_);
    const Instant now = time_.now();
    if (active == level_) return now;
    edge = add(now, active);
  }
  changed_.notify_all();
  if (heard_) heard_(edge);
  return edge.at;
}

void SimulatedWire::listen(std::function<void(const Edge&)> heard) {
  const std::lock_guard lock(listening_);
  heard_ = std::move(heard);
}

void SimulatedWire::strobe(Instant begin, Duration width) {
  {
    const std::lock_guard lock(mutex_);
    (void)add(begin, true), (void)add(begin + width, false);
  }
  changed_.notify_all();
}

bool SimulatedWire::level() const {
  const std::lock_guard lock(mutex_);
  return level_;
}

SimulatedSyncLine::SimulatedSyncLine(SimulatedWire& wire) : wire_(wire) {
  const std::lock_guard lock(wire.mutex_);
  first_ = next_ = wire.count_;
}

Result<Edge> SimulatedSyncLine::wait_edge(Duration timeout) {
  std::unique_lock lock(wire_.mutex_);
  const Instant deadline = wire_.time_.now() + timeout;
  for (;;) {
    if (closed_) return kClosed;
    if (wire_.count_ > SimulatedWire::kEdges) next_ = std::max(next_, wire_.count_ - SimulatedWire::kEdges);
    const Instant now = wire_.time_.now();
    Instant due = deadline;
    if (next_ < wire_.count_) {
      Edge edge = wire_.edges_[next_ % SimulatedWire::kEdges];
      if (edge.at <= now) {
        edge.sequence = next_++ - first_;
        return edge;
      }
      due = std::min(edge.at, deadline);
    }
    if (now >= deadline)
      return Error{ErrorCode::Timeout,
                   fmt::format("no edge came within {:.3f} ms", to_seconds(timeout) * 1e3)};
    wire_.time_.wait(lock, wire_.changed_, due);
  }
}

void SimulatedSyncLine::close() {
  {
    const std::lock_guard lock(wire_.mutex_);
    closed_ = true;
  }
  wire_.changed_.notify_all();
}

}  // namespace hdrcam
