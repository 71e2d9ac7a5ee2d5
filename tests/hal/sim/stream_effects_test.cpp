// What a simulation does to its stream, by its plan of effects.
#include "hal/sim/stream_effects.h"

#include "tests/contracts/expect.h"

using namespace hdrcam;
using namespace std::chrono_literals;

TEST_CASE("without effects on the stream no frame is lost, and clocks agree") {
  const StreamEffects stream(value_of(simulation_of("still")));
  for (std::uint64_t i = 0; i < 1000; ++i) {
    CHECK_FALSE(stream.loses(i));
    CHECK(stream.latency(i) == 0ns);
  }
  CHECK(stream.host_time(100s) == 100s);
}

TEST_CASE("a simulation's seed decides which frames are lost and how late they are stamped") {
  const std::string scene = "still?with=clock-jitter&drops=0.25&seed=";
  const Simulation simulation = value_of(simulation_of(scene + "7"));
  const StreamEffects stream(simulation), other(value_of(simulation_of(scene + "8")));
  const Drops drops(simulation.drops, 7);
  const ClockJitter jitter(simulation.clock_jitter, 7);
  int differ = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    CHECK(stream.loses(i) == drops.lost(i));
    CHECK(stream.latency(i) == jitter.latency(i));
    differ += stream.loses(i) != other.loses(i);
  }
  CHECK(differ > 100);
  CHECK(stream.host_time(100s) == jitter.stretched(100s));
}
