#include "online/priors/motion/landing.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 40, kCols = 60;
struct Flows {
  Image<float> there{2, kRows, kCols}, back{2, kRows, kCols};
  // A pixel that moves, and the pixel where it arrives, which moves back.
  void move(int x, int y, int u, int v) {
    there.at(0, y, x) = static_cast<float>(u), there.at(1, y, x) = static_cast<float>(v);
    if (x + u < 0 || x + u >= kCols || y + v < 0 || y + v >= kRows) return;
    back.at(0, y + v, x + u) = static_cast<float>(-u), back.at(1, y + v, x + u) = static_cast<float>(-v);
  }
};

}  // namespace

TEST_CASE("of what lands in a cell the fastest stays, and it lands beside where nothing does") {
  Flows flows;
  // half of the way: to 20, 20 all four
  flows.move(30, 20, -20, 0), flows.move(8, 20, 24, 0), flows.move(20, 14, 0, 12);
  flows.move(20, 34, 0, -28), flows.back.at(1, 6, 20) = 20;  // faster, but the way back is another
  flows.move(50, 10, 20, 0);                                 // leaves the picture
  flows.move(4, 36, 10, 0);                                  // not fast
  Landing landing(kRows, kCols);
  const Image<float>& cells = landing.cells();
  REQUIRE(cells.rows() == 5);
  REQUIRE(cells.cols() == 8);
  landing.throw_ahead(flows.there, flows.back, 11, 0.5f);
  for (int row = 0; row < cells.rows(); ++row)
    for (int col = 0; col < cells.cols(); ++col) {
      CAPTURE(row, col);
      const bool near = row >= 1 && row <= 3 && col >= 1 && col <= 3;
      CHECK(cells.at(0, row, col) == (near ? 24 : kNowhere));
      CHECK(cells.at(1, row, col) == (near ? 0 : kNowhere));
    }
  landing.throw_ahead(flows.back, flows.there, 40, 0.5f);
  CHECK(cells.at(0, 2, 2) == kNowhere);
}
