#include "capture/strobe_pulses.h"

#include <algorithm>
#include <chrono>

namespace hdrcam {

void StrobePulses::add(const Edge& edge) {
  const bool lost_edges = count_ > 0 && edge.sequence != edge_sequence_ + 1;
  edge_sequence_ = edge.sequence;
  if (lost_edges) last_.reset();
  if (edge.rising) {
    pulses_[count_ % kKept] = {count_, edge.at, std::nullopt};
    ++count_;
  } else if (line_high_ && !lost_edges) {
    Pulse& newest = pulses_[(count_ - 1) % kKept];
    newest.width = edge.at - newest.rise;
  }
  line_high_ = edge.rising;
}

// The edge at the moment that the timestamp marks: exposures differ, so the end of one is a constant time
// from the falling edge only. nullopt where that edge was not seen.
std::optional<Instant> StrobePulses::marked_edge(const Pulse& pulse) const {
  if (!by_end_) return pulse.rise;
  return pulse.width ? std::optional(pulse.rise + *pulse.width) : std::nullopt;
}

std::optional<StrobePulses::Pulse> StrobePulses::pulse_of(Instant timestamp, Duration within) const {
  if (kind_ == StrobePulse::Absent) return std::nullopt;
  const Instant expected = timestamp + after_timestamp_;
  std::optional<Pulse> nearest;
  Duration least = within;
  for (std::uint64_t back = 1; back <= std::min<std::uint64_t>(count_, kKept); ++back) {
    const Pulse& pulse = pulses_[(count_ - back) % kKept];
    const auto edge = marked_edge(pulse);
    if (!edge) continue;
    const Duration off = std::chrono::abs(*edge - expected);
    if (off <= least) least = off, nearest = pulse;
  }
  return nearest;
}

bool StrobePulses::forgot(Instant timestamp) const {
  return count_ > kKept && timestamp + after_timestamp_ < pulses_[count_ % kKept].rise;
}

std::int64_t StrobePulses::since_last(const std::optional<Pulse>& pulse) const {
  return pulse && last_ ? static_cast<std::int64_t>(pulse->number - *last_) : 0;
}

void StrobePulses::matched(const std::optional<Pulse>& pulse) {
  last_ = pulse ? std::optional(pulse->number) : std::nullopt;
}

}  // namespace hdrcam
