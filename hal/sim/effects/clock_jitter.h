// Clock jitter: the sensor's crystal differs from the host's (drift), and a timestamp is taken shortly after
// the event (interrupt latency: |normal|). Value type, reentrant.
#pragma once

#include <cmath>
#include <cstdint>

#include "hal/core/instant.h"
#include "hal/sim/counter_random.h"

namespace hdrcam {

struct ClockJitterSettings {
  double latency_s = 40e-6;  // standard deviation of the normal number behind the latency
  double drift_ppm = 20;     // > 0: the sensor runs slow
};

class ClockJitter {
 public:
  ClockJitter(ClockJitterSettings settings, std::uint64_t seed)
      : settings_(settings), random_(seed, 0x6a697474) {}

  // The sensor's period, measured in the host's time.
  Duration stretched(Duration sensor_time) const {
    const auto more = static_cast<double>(sensor_time.count()) * settings_.drift_ppm * 1e-6;
    return sensor_time + Duration(std::llround(more));
  }
  Duration latency(std::uint64_t event) const {
    return Duration(std::llround(settings_.latency_s * std::abs(random_.normals(event).a) * 1e9));
  }

 private:
  ClockJitterSettings settings_;
  CounterRandom random_;
};

}  // namespace hdrcam
