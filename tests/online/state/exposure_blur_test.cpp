#include "online/state/exposure_blur.h"

#include "tests/online/state/moving_edge.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::MovingEdge;

TEST_CASE("an edge that moves is blurred over its way during the exposure, and what is at rest is not") {
  WorkerPool pool(2);
  const Image<float> sharp = MovingEdge::picture();
  Image<float> added;
  for (const float share : {0.75f, 0.25f}) {
    blur_difference(sharp, MovingEdge::to_the_right(8), share, added, pool);
    for (int x = 16; x < 48; ++x) {
      INFO("column " << x << ", exposed for " << share << " of the interval");
      CHECK(sharp.at(1, 8, x) + added.at(1, 8, x) == Approx(MovingEdge::ramp(x, share * 8)).margin(0.05));
    }
  }
  blur_difference(sharp, MovingEdge::to_the_right(8), 0.02f, added, pool);
  for (const float a : added.samples()) REQUIRE(a == 0);
}

TEST_CASE("an exposure blurs where any motion in it is long enough to be seen", "[isa]") {
  WorkerPool pool(2);
  Image<float> flow(2, MovingEdge::kRows, MovingEdge::kCols - 1);  // not whole vectors
  flow.fill(0);
  CHECK_FALSE(exposure_blurs(flow, 1, pool));
  flow.at(1, MovingEdge::kRows - 1, MovingEdge::kCols - 2) = -4;
  CHECK(exposure_blurs(flow, 0.5f, pool));
  CHECK_FALSE(exposure_blurs(flow, 0.05f, pool));
}
