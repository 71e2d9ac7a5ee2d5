// The pulses that were driven on the trigger line, found by the time of the frames that they began.
// Thread-bound; bounded state, no allocation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "capture/pulse_train.h"
#include "hal/camera.h"

namespace hdrcam {

class TriggerPulses {
 public:
  // interval: between pulses, at least.
  TriggerPulses(TriggerMode mode, TimestampMark mark, Duration interval)
      : mode_(mode), mark_(mark), interval_(interval) {}

  // Adds a pulse, in order.
  void add(const TriggerPulse& pulse) { pulses_[count_++ % kKept] = pulse; }
  // The pulse that began the frame with this timestamp.
  std::optional<TriggerPulse> pulse_of(Instant timestamp) const;
  // Whether a frame with this timestamp is older than all pulses that are kept, and there were others.
  bool forgot(Instant timestamp) const {
    return count_ > kKept && timestamp < pulses_[count_ % kKept].rise.at;
  }

  // Pulses driven from the last frame's to this one; 0 where either frame has none.
  int since_last(const std::optional<TriggerPulse>& pulse) const;
  // Pulses between them that were planned but not driven; 0 likewise.
  int left_out_since_last(const std::optional<TriggerPulse>& pulse) const;
  // Notes the pulse of the next frame, or that it has none.
  void matched(const std::optional<TriggerPulse>& pulse) { last_ = pulse; }
  // The last frame's.
  const std::optional<TriggerPulse>& last() const { return last_; }

 private:
  // A capture thread that is late brings all pulses that waited before the first of their frames.
  static constexpr std::size_t kKept = kMostWaitingPulses;

  TriggerMode mode_;
  TimestampMark mark_;
  Duration interval_;
  std::array<TriggerPulse, kKept> pulses_{};  // the n-th at n % kKept
  std::uint64_t count_ = 0;
  std::optional<TriggerPulse> last_;
};

}  // namespace hdrcam
