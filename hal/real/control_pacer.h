// When to write a control that acts "now" and not with a frame of its own (a sensor sub-device, a USB
// camera): one request's exposure per frame, as soon as the frame before it is complete. So a request written
// at frame k shows at frame k + delay, with the delay of the device and nothing else, however many requests
// wait in the queue. No allocation. Thread-compatible.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/camera.h"

namespace hdrcam {

class ControlPacer {
 public:
  static constexpr int kDepth = 64;  // buffers of a stream, at most

  void restart() { queued_ = completed_ = written_ = 0; }

  void queued(const ExposureRequest& request) { ring_[queued_++ % kDepth] = request; }
  void completed() { ++completed_; }

  // The exposure to write now, once; nullopt where it is written already or not yet known.
  std::optional<ExposureRequest> due() {
    if (completed_ >= queued_ || written_ > completed_) return std::nullopt;
    written_ = completed_ + 1;
    return current();
  }
  // The exposure of the next frame, written already or not. There is one in the queue.
  const ExposureRequest& current() const { return ring_[completed_ % kDepth]; }

 private:
  std::array<ExposureRequest, kDepth> ring_{};
  std::uint64_t queued_ = 0, completed_ = 0;
  std::uint64_t written_ = 0;  // requests before this one are written or were missed
};

}  // namespace hdrcam
