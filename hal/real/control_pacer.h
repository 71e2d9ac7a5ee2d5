// Decides when to write a control that acts immediately instead of with its own frame (a sensor sub-device, a
// USB camera): one request's exposure per frame, as soon as the previous frame is complete. So a request
// written at frame k acts at frame k + delay, where the delay is that of the device only, however many
// requests are queued. A write that a busy machine delayed breaks that rule and is reported. No allocation.
// Thread-compatible.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "hal/camera.h"

namespace hdrcam {

class ControlPacer {
 public:
  static constexpr int kDepth = 64;  // buffers of a stream, at most

  // The exposure of one frame, to be written now.
  struct Turn {
    std::uint64_t index = 0;
    ExposureRequest request;
  };

  void restart() { *this = {}; }
  void queued(const ExposureRequest& request) { ring_[queued_++ % kDepth] = {request, true}; }

  // The exposure of the next frame; nullopt where it is not yet known.
  std::optional<Turn> next() const {
    if (completed_ >= queued_) return std::nullopt;
    return Turn{completed_, ring_[completed_ % kDepth].request};
  }
  // The same, but nullopt where it is already written.
  std::optional<Turn> due() const { return unwritten_ > completed_ ? std::nullopt : next(); }

  void written(const Turn& turn, Instant now) {
    if (turn.index < unwritten_) return;
    unwritten_ = turn.index + 1;
    if (turn.index == completed_) ring_[turn.index % kDepth].late = turn.index > 0 && is_late(now - begun_);
  }
  // It was not written, though it was said to be, or will not be: its frame goes without.
  void given_up(const Turn& turn) {
    if (turn.index < completed_) return;
    unwritten_ = std::max(unwritten_, turn.index + 1);
    ring_[turn.index % kDepth].late = true;
  }
  // Records a complete frame. Returns whether its request's exposure was written late or never.
  bool completed(Instant timestamp) {
    if (completed_ > 0) interval_.add(timestamp - begun_);
    begun_ = timestamp;
    return ring_[completed_++ % kDepth].late;
  }

 private:
  struct Entry {
    ExposureRequest request;
    bool late = true;  // until it is written
  };

  // A median that follows slowly: one outlier moves it by a 32nd.
  struct RunningMedian {
    std::optional<Duration> value;
    void add(Duration sample) {
      if (!value) value = sample;
      const Duration step = std::max(std::chrono::abs(*value) / 32, Duration(10'000));
      *value += std::clamp(sample - *value, -step, step);
    }
  };

  // The point in a frame at which a camera takes over a written control is unknown. But the control's delay
  // was measured with writes at the usual time and holds for those.
  bool is_late(Duration after_timestamp) {
    const bool late =
        usual_.value && interval_.value && after_timestamp > *usual_.value + *interval_.value / 4;
    usual_.add(after_timestamp);
    return late;
  }

  std::array<Entry, kDepth> ring_{};
  std::uint64_t queued_ = 0, completed_ = 0;
  std::uint64_t unwritten_ = 0;     // requests before this one are written or were missed
  Instant begun_;                   // timestamp of the frame completed last
  RunningMedian interval_, usual_;  // from timestamp to timestamp, and to the write for the next frame
};

}  // namespace hdrcam
