#include "hal/real/recent_stamp.h"

#include <algorithm>
#include <chrono>

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
  constexpr Duration kMostAhead = std::chrono::milliseconds(500);
  const Instant stated = clock.instant_of(domain, stamp), now = clock.now();
  if (stated - now > kMostAhead) return instant_of_recent_stamp(clock, stamp);
  return std::min(stated, now);
}

}  // namespace hdrcam
