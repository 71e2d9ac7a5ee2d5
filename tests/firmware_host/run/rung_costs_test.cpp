#include "firmware_host/run/rung_costs.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("what a rung takes follows the speed of the machine, and is not known before its first use") {
  RungCosts costs(3);
  CHECK_FALSE(costs.knows(1));
  CHECK_FALSE(costs.frame_ms(1, 5));
  costs.remember(1, 2);
  CHECK(costs.knows(1));
  CHECK(costs.frame_ms(1, 5) == Approx(10));
  CHECK(costs.frame_ms(1, 15) == Approx(30));
  CHECK_FALSE(costs.knows(0));
  costs.forget(1);
  CHECK_FALSE(costs.frame_ms(1, 5));
}

TEST_CASE("a rung that was never in use lies evenly between the present one and the next known below it") {
  const FrameTime now{.total_ms = 40, .steady_ms = 10};
  RungCosts costs(5);
  CHECK_FALSE(costs.expected_ms(1, 0, now));
  costs.remember(3, 1);
  CHECK(costs.expected_ms(1, 0, now) == Approx(30));
  CHECK(costs.expected_ms(2, 0, now) == Approx(20));
  CHECK(costs.expected_ms(3, 0, now) == Approx(10));
  CHECK_FALSE(costs.expected_ms(4, 0, now));  // none below it is known
  costs.remember(2, 3);
  CHECK(costs.expected_ms(1, 0, now) == Approx(35));
  CHECK(costs.expected_ms(2, 1, now) == Approx(30));  // as known, wherever the run is
}

}  // namespace
}  // namespace hdrcam
