#include "hal/real/recent_stamp.h"

#include "hal/sim/virtual_clock.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace std::chrono_literals;

TEST_CASE("a stamp of an unknown clock is of the one that is near it now") {
  VirtualClock clock(Instant::from_seconds(500));
  const Duration stamp = 499'970ms;
  CHECK(instant_of_recent_stamp(clock, stamp).since_boot == stamp);
  CHECK(instant_of_recent_stamp(clock, stamp + VirtualClock::kRealtimeStart).since_boot == stamp);
}

TEST_CASE("a frame is not stamped later than it is there, whatever its driver says") {
  VirtualClock clock(Instant::from_seconds(500));
  CHECK(instant_of_recent_stamp(clock, 500s) == clock.now());
  CHECK(instant_of_recent_stamp(clock, 1500s) == clock.now());
  CHECK(instant_of_recent_stamp(clock, 1500s + VirtualClock::kRealtimeStart) == clock.now());
  CHECK(instant_of_recent_stamp(clock, ClockDomain::Monotonic, 1500s) == clock.now());
  CHECK(instant_of_recent_stamp(clock, ClockDomain::Monotonic, 499s).since_boot == 499s);
}

TEST_CASE("a stamp that is far ahead of the clock which its driver states is of the one that is near it") {
  VirtualClock clock(Instant::from_seconds(500));
  const Duration stamp = 499'970ms;
  CHECK(instant_of_recent_stamp(clock, ClockDomain::Monotonic, stamp + VirtualClock::kRealtimeStart)
            .since_boot == stamp);
  CHECK(instant_of_recent_stamp(clock, ClockDomain::Monotonic, 500'300ms) == clock.now());
}
