#include "online/priors/motion/landing.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("of what lands in a cell the fastest stays, and it lands beside where nothing does") {
  Landing landing(40, 60);
  REQUIRE(landing.cells().rows() == 5);
  REQUIRE(landing.cells().cols() == 8);
  // half of the way: to 20, 20 all three; the last one leaves the picture
  landing.throw_ahead({{10, 20, 20, 0}, {30, 20, -24, 0}, {20, 14, 0, 10}, {50, 20, 30, 0}}, 0.5f, 2);
  const Image<float>& cells = landing.cells();
  for (int row = 0; row < cells.rows(); ++row)
    for (int col = 0; col < cells.cols(); ++col) {
      CAPTURE(row, col);
      const bool near = row >= 1 && row <= 3 && col >= 1 && col <= 3;
      CHECK(cells.at(0, row, col) == (near ? -48 : kNowhere));
      CHECK(cells.at(1, row, col) == (near ? 0 : kNowhere));
    }
  landing.throw_ahead({}, 0.5f, 2);
  CHECK(cells.at(0, 2, 2) == kNowhere);
}

TEST_CASE("movers are the pixels that are fast and believed") {
  Image<float> motion(2, 8, 8);
  motion.at(0, 2, 4) = 9, motion.at(1, 2, 4) = -4;
  motion.at(0, 4, 4) = 30;
  motion.at(0, 6, 6) = 7;
  std::vector<Mover> movers;
  find_movers(
      motion, 8, [](int, int y) { return y != 4; }, movers);
  REQUIRE(movers.size() == 1);
  CHECK(movers[0].x == 4);
  CHECK(movers[0].y == 2);
  CHECK(movers[0].u == 9);
  CHECK(movers[0].v == -4);
}
