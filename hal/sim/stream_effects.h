// What happens to a simulation's frames between sensor and host: which of them are lost, and how the host's
// clock sees their times. The same for a camera and for a clip, frame by frame. An effect that the plan has
// off changes nothing. Value type, reentrant.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/sim/simulation.h"

namespace hdrcam {

class StreamEffects {
 public:
  explicit StreamEffects(const Simulation& simulation);

  bool loses(std::uint64_t sequence) const { return drops_ && drops_->lost(sequence); }
  // The sensor's time since its start, as the host's clock measures it.
  Duration host_time(Duration sensor_time) const {
    return jitter_ ? jitter_->stretched(sensor_time) : sensor_time;
  }
  // By how much the frame's timestamp is later than what it marks.
  Duration latency(std::uint64_t sequence) const {
    return jitter_ ? jitter_->latency(sequence) : Duration::zero();
  }

 private:
  std::optional<Drops> drops_;
  std::optional<ClockJitter> jitter_;
};

}  // namespace hdrcam
