#include "hal/real/sync_line_gpiod.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <utility>

#include "hal/clock.h"
#include "hal/real/device_node.h"
#include "hal/real/recent_stamp.h"

namespace hdrcam {
namespace {

using SteadyClock = std::chrono::steady_clock;

class GpioSyncLine : public SyncLine {
 public:
  GpioSyncLine(std::unique_ptr<GpioLine> line, GpioSettings settings)
      : line_(std::move(line)), settings_(std::move(settings)) {}

  Result<Edge> wait_edge(Duration timeout) override {
    const auto deadline = SteadyClock::now() + timeout;
    for (;;) {
      if (closed_) return closed();
      const Duration left = std::max<Duration>(deadline - SteadyClock::now(), Duration::zero());
      const bool edge = wake_.sleep(line_->event_fd(), left).device != 0;
      if (closed_) return closed();
      if (edge) return next_edge();
      if (SteadyClock::now() >= deadline)
        return Error{ErrorCode::Timeout,
                     fmt::format("no edge on GPIO line '{}' within {} ms", settings_.line,
                                 std::chrono::duration_cast<std::chrono::milliseconds>(timeout).count())};
    }
  }

  void close() override {
    closed_ = true;
    wake_.set();
  }

 private:
  Error closed() const {
    return {ErrorCode::Interrupted, fmt::format("GPIO line '{}' is closed", settings_.line)};
  }

  // Edges alternate. Where the kernel does not count them, two equal edges in a row show that one between
  // them was lost.
  Result<Edge> next_edge() {
    const GpioEvent event = TRY(line_->read_event());
    if (event.line_sequence)
      sequence_ = *event.line_sequence;
    else
      sequence_ += sequence_ > 0 && event.rising == last_rising_ ? 2 : 1;
    last_rising_ = event.rising;
    return Edge{instant_of_recent_stamp(posix_clock(), event.stamp), event.rising, sequence_};
  }

  std::unique_ptr<GpioLine> line_;
  GpioSettings settings_;
  WakeUp wake_;
  std::atomic<bool> closed_{false};
  std::uint64_t sequence_ = 0;
  bool last_rising_ = false;
};

}  // namespace

Result<std::unique_ptr<SyncLine>> open_gpio_line(const GpioSettings& settings) {
  auto line = TRY(request_gpio_line(settings, LineDirection::Input));
  return std::unique_ptr<SyncLine>(std::make_unique<GpioSyncLine>(std::move(line), settings));
}

}  // namespace hdrcam
