#include "hal/core/mirrored.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("rows are mirrored at the border, and again where a picture ends before") {
  CHECK(mirrored(-2, 5) == 2);
  CHECK(mirrored(4, 5) == 4);
  CHECK(mirrored(6, 5) == 2);
  CHECK(mirrored(-1, 2) == 1);
  CHECK(mirrored(-2, 2) == 0);
  CHECK(mirrored(2, 2) == 0);
  CHECK(mirrored(-2, 1) == 0);
  CHECK(mirrored(2, 1) == 0);
}
