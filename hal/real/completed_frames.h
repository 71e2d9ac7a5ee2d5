// The number and the time of the frames that a camera's requests completed. A cancelled request says nothing
// of its frame, and its buffer still holds the number and the time of the frame before it in that buffer: it
// counts as the next frame, one interval after the last one. Thread-compatible.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "hal/core/instant.h"

namespace hdrcam {

class CompletedFrames {
 public:
  struct Place {
    std::uint64_t sequence = 0;
    Instant timestamp;
  };

  void restart() { last_.reset(); }
  // As the driver states them.
  Place completed(std::uint64_t sequence, Instant timestamp) {
    return last_.emplace(Place{sequence, timestamp});
  }
  // interval: between frames.
  Place cancelled(Instant now, Duration interval) {
    if (!last_) return completed(0, now);
    return completed(last_->sequence + 1, std::min(now, last_->timestamp + interval));
  }

 private:
  std::optional<Place> last_;
};

}  // namespace hdrcam
