#include "hal/sim/simulated_sync_line.h"

#include <algorithm>

namespace hdrcam {
namespace {

const Error kClosed{ErrorCode::Interrupted, "the simulated line was closed"};

}  // namespace

void SimulatedWire::add(Instant at, bool rising) {
  edges_[count_ % kEdges] = {at, rising, count_};
  ++count_;
  level_ = rising;
}

void SimulatedWire::drive(bool active) {
  {
    const std::lock_guard lock(mutex_);
    if (active == level_) return;
    add(time_.now(), active);
  }
  changed_.notify_all();
}

void SimulatedWire::strobe(Instant begin, Duration width) {
  {
    const std::lock_guard lock(mutex_);
    add(begin, true), add(begin + width, false);
  }
  changed_.notify_all();
}

bool SimulatedWire::level() const {
  const std::lock_guard lock(mutex_);
  return level_;
}

SimulatedSyncLine::SimulatedSyncLine(SimulatedWire& wire, LineDirection direction)
    : wire_(wire), direction_(direction) {
  const std::lock_guard lock(wire.mutex_);
  first_ = next_ = wire.count_;
}

SyncLineCapabilities SimulatedSyncLine::capabilities() const {
  return {.output = direction_ == LineDirection::Output, .input = direction_ == LineDirection::Input};
}

Result<void> SimulatedSyncLine::pulse(Duration width) {
  if (direction_ != LineDirection::Output)
    return Error{ErrorCode::Unsupported, "the simulated line is an input; it drives nothing"};
  if (width <= Duration::zero())
    return Error{
        ErrorCode::Invalid,
        fmt::format("a pulse width of {} ns is out of range; ask for a positive width", width.count())};
  if (closed_) return kClosed;
  wire_.drive(true);
  wire_.time_.sleep_until(wire_.time_.now() + width);
  wire_.drive(false);
  return {};
}

Result<Edge> SimulatedSyncLine::wait_edge(Duration timeout) {
  if (direction_ != LineDirection::Input)
    return Error{ErrorCode::Unsupported, "the simulated line is an output; it reports no edges"};
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
