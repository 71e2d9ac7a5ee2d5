#include <time.h>

#include "hal/clock.h"
#include "tests/contracts/clock_contract.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the machine's clock keeps the clock contract") {
  keeps_clock_contract({.name = "posix", .clock = posix_clock(), .stamp = [](ClockDomain domain) {
                          const clockid_t id = domain == ClockDomain::Boot        ? CLOCK_BOOTTIME
                                               : domain == ClockDomain::Monotonic ? CLOCK_MONOTONIC
                                                                                  : CLOCK_REALTIME;
                          timespec now{};
                          clock_gettime(id, &now);
                          return Duration(std::chrono::seconds(now.tv_sec)) +
                                 std::chrono::nanoseconds(now.tv_nsec);
                        }});
}
