#include "hal/real/recent_stamp.h"

#include <algorithm>

namespace hdrcam {

Instant instant_of_recent_stamp(Clock& clock, Duration stamp) {
  const Instant now = clock.now();
  Instant nearest = clock.instant_of(ClockDomain::Monotonic, stamp);
  for (const ClockDomain domain : {ClockDomain::Boot, ClockDomain::Realtime}) {
    const Instant candidate = clock.instant_of(domain, stamp);
    // Only a clear win counts: the boot and monotonic clocks agree until the first suspend.
    if (std::chrono::abs(candidate - now) + std::chrono::milliseconds(500) < std::chrono::abs(nearest - now))
      nearest = candidate;
  }
  return std::min(nearest, now);
}

Instant instant_of_recent_stamp(Clock& clock, ClockDomain domain, Duration stamp) {
  return std::min(clock.instant_of(domain, stamp), clock.now());
}

}  // namespace hdrcam
