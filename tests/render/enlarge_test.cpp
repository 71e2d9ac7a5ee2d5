#include "render/enlarge.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a reduced picture is enlarged between the middles of its pixels, and at its border as they are") {
  WorkerPool pool(2);
  Image<float> ramp(2, 3, 4), large;
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) ramp.at(1, y, x) = static_cast<float>(16 * y + 4 * x);
  enlarge(ramp, 2, 6, 8, large, pool);
  CHECK(large.channels() == 2);
  CHECK(large.rows() == 6);
  CHECK(large.cols() == 8);
  CHECK(large.at(1, 0, 0) == 0);
  CHECK(large.at(1, 1, 1) == 5);  // a quarter of the way along both axes
  CHECK(large.at(1, 2, 4) == 19);
  CHECK(large.at(1, 5, 7) == 44);
  enlarge(ramp, 1, 3, 4, large, pool);
  CHECK(large.same_shape(ramp));
  CHECK(large.at(1, 2, 3) == 44);
}
