// The effects on the stream, each against its formula.
#include "hal/sim/effects/clock_jitter.h"
#include "hal/sim/effects/delayed_control.h"
#include "hal/sim/effects/drops.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a control shows exactly its delay after it was written, for every delay") {
  for (int delay = 0; delay <= DelayedControl<int>::kMost; ++delay) {
    DelayedControl<int> control(delay, -1);
    for (int frame = 0; frame < 50; ++frame) {
      control.write(static_cast<std::uint64_t>(frame), 100 + frame);
      INFO("delay " << delay << ", frame " << frame);
      CHECK(control.latch(static_cast<std::uint64_t>(frame)) == (frame < delay ? -1 : 100 + frame - delay));
    }
  }
}

TEST_CASE("a control holds its value while nobody writes") {
  DelayedControl<int> control(2, 5);
  control.write(0, 9);
  CHECK(control.latch(0) == 5);
  CHECK(control.latch(1) == 5);
  for (std::uint64_t frame = 2; frame < 40; ++frame) CHECK(control.latch(frame) == 9);
}

TEST_CASE("a control may be early or late, but never before its own frame") {
  DelayedControl<int> control(1, 0);
  control.write(0, 7, -3);
  CHECK(control.latch(0) == 7);
  control.write(1, 8, 1);
  CHECK(control.latch(1) == 7);
  CHECK(control.latch(2) == 7);
  CHECK(control.latch(3) == 8);
}

TEST_CASE("frames are dropped as often as asked and the same ones each time") {
  const Drops drops({.probability = 0.25}, 4), same({.probability = 0.25}, 4), never({.probability = 0}, 4),
      always({.probability = 1}, 4);
  int lost = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    lost += drops.lost(i);
    REQUIRE(drops.lost(i) == same.lost(i));
    REQUIRE_FALSE(never.lost(i));
    REQUIRE(always.lost(i));
  }
  CHECK(lost == Approx(5000).margin(310));  // five standard deviations
}

TEST_CASE("a sensor's clock drifts by its parts per million and stamps come late, never early") {
  const ClockJitter jitter({.latency_s = 40e-6, .drift_ppm = 20}, 1);
  CHECK(jitter.stretched(std::chrono::seconds(100)) ==
        std::chrono::seconds(100) + std::chrono::milliseconds(2));
  double sum = 0;
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    const Duration latency = jitter.latency(i);
    REQUIRE(latency >= Duration::zero());
    sum += to_seconds(latency);
  }
  CHECK(sum / 1e4 == Approx(40e-6 * std::sqrt(2 / 3.14159265)).epsilon(0.03));  // mean of |normal|
}
