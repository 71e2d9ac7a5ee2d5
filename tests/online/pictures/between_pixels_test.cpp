#include "online/pictures/between_pixels.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a picture is read between its pixels, and beyond its border as at it") {
  Image<float> ramp(2, 3, 4);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) ramp.at(1, y, x) = static_cast<float>(10 * y + x);
  const auto read = [&](float x, float y) { return BetweenPixels(3, 4, 0, 0, {x, y}).of(ramp, 1); };
  CHECK(read(1.25f, 0.5f) == Approx(6.25f));
  CHECK(read(3, 2) == 23);
  CHECK(read(-7, 1) == 10);
  CHECK(read(9, 9) == 23);
  CHECK(read(std::nanf(""), 1) == 10);
  CHECK(BetweenPixels(1, 1, 0, 0, {0.5f, 0.5f}).of(Image<float>(1, 1, 1), 0) == 0);
}

TEST_CASE("a place on a line of pixels lies between two of them, beyond its ends at the last ones") {
  const auto is = [](AxisTap tap, int low, int high, float share) {
    return tap.low == low && tap.high == high && tap.share == share;
  };
  CHECK(is(tap_at(1.25f, 4), 1, 2, 0.25f));
  CHECK(is(tap_at(-2, 4), 0, 1, 0));
  CHECK(is(tap_at(3, 4), 3, 3, 0));
  CHECK(is(tap_at(3.5f, 4), 3, 3, 0));
  CHECK(is(tap_at(0.5f, 1), 0, 0, 0));
}
