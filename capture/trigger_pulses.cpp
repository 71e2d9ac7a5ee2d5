#include "capture/trigger_pulses.h"

#include <algorithm>
#include <chrono>

namespace hdrcam {

// Found by the edge that the timestamp marks, within a quarter of an interval. A driver that stamps the end
// of exposures set by controls leaves only the order: the pulse before.
std::optional<TriggerPulse> TriggerPulses::pulse_of(Instant timestamp) const {
  if (mode_ == TriggerMode::Off) return std::nullopt;
  const bool stamps_end = mark_ == TimestampMark::ExposureEnd, exposes = mode_ == TriggerMode::PulseWidth;
  const bool by_end = stamps_end && exposes, by_order = stamps_end && !exposes;
  Duration least = by_order ? interval_ : interval_ / 4;
  std::optional<TriggerPulse> nearest;
  for (std::uint64_t back = 1; back <= std::min<std::uint64_t>(count_, kKept); ++back) {
    const TriggerPulse& pulse = pulses_[(count_ - back) % kKept];
    const Duration off = timestamp - (by_end ? pulse.fall.at : pulse.rise.at);
    if (off >= least) break;  // as are all pulses before it
    if (by_order && off < Duration(0)) continue;
    if (std::chrono::abs(off) < least) least = std::chrono::abs(off), nearest = pulse;
  }
  return nearest;
}

int TriggerPulses::since_last(const std::optional<TriggerPulse>& pulse) const {
  if (!pulse || !last_ || pulse->index <= last_->index) return 0;
  return static_cast<int>(pulse->index - last_->index);
}

int TriggerPulses::left_out_since_last(const std::optional<TriggerPulse>& pulse) const {
  if (!pulse || !last_ || pulse->index <= last_->index) return 0;  // a stamp that steps back
  return static_cast<int>((pulse->planned.number - last_->planned.number) - (pulse->index - last_->index));
}

}  // namespace hdrcam
