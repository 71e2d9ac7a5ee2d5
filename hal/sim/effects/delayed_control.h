// Control delay: a value written to a sensor's register while frame n is read acts from frame n + delay on.
// One object per control, so that exposure and gain may differ. Value type, thread-bound.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "hal/core/check.h"

namespace hdrcam {

template <class Value>
class DelayedControl {
 public:
  static constexpr int kMost = 7;  // frames

  DelayedControl(int delay, Value initial) : delay_(delay), current_(initial) {
    HDRCAM_CHECK(delay >= 0 && delay <= kMost);
  }

  // `frame` counts up; `late`: additional frames of delay (negative: fewer).
  void write(std::uint64_t frame, Value value, int late = 0) {
    const int after = std::clamp(delay_ + late, 0, kMost);
    pending_[(frame + static_cast<std::uint64_t>(after)) % kSlots] = value;
  }
  // The value that acts on frame `frame`. Called once per frame, in order, after the writes of that frame.
  Value latch(std::uint64_t frame) {
    std::optional<Value>& due = pending_[frame % kSlots];
    if (due) current_ = *due, due.reset();
    return current_;
  }

 private:
  static constexpr std::size_t kSlots = kMost + 1;
  int delay_;
  Value current_;
  std::array<std::optional<Value>, kSlots> pending_;
};

}  // namespace hdrcam
