// The time from frame to frame, as measured: not every camera keeps the frame duration that it agreed to.
// Thread-bound; bounded state, no allocation.
#pragma once

#include <array>
#include <cstdint>

#include "hal/core/instant.h"

namespace hdrcam {

class FrameInterval {
 public:
  explicit FrameInterval(Duration agreed) : agreed_(agreed), value_(agreed) {}

  // So many frames took this long; both greater than 0. Frames that were lost unnoticed make it long: the
  // median leaves them out.
  void observe(std::uint64_t frames, Duration elapsed);

  // The agreed duration until a few intervals are known, and as long as they differ from it by no more than
  // timestamps do.
  Duration value() const { return value_; }
  bool measured() const { return count_ >= kNeeded; }
  double frames_in(Duration elapsed) const {
    return static_cast<double>(elapsed.count()) / static_cast<double>(value_.count());
  }

 private:
  static constexpr std::size_t kKept = 8, kNeeded = 3;  // intervals

  Duration agreed_, value_;
  std::array<Duration, kKept> intervals_{};  // the n-th at n % kKept
  std::uint64_t count_ = 0;
};

}  // namespace hdrcam
