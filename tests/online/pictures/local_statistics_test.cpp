#include "online/pictures/local_statistics.h"

#include <algorithm>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// Small whole numbers: their sums are exact in any order.
Image<float> picture(int rows, int cols) {
  Image<float> in(1, rows, cols);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x) in.at(0, y, x) = static_cast<float>((7 * y + 3 * x + 5) % 11);
  return in;
}

Image<float> on_its_side(const Image<float>& in) {
  Image<float> out(1, in.cols(), in.rows());
  for (int y = 0; y < in.rows(); ++y)
    for (int x = 0; x < in.cols(); ++x) out.at(0, x, y) = in.at(0, y, x);
  return out;
}

}  // namespace

TEST_CASE("a mean does not depend on which side a picture lies on, however low it is") {
  WorkerPool pool(1);
  for (const int rows : {1, 2, 3, 4, 5})
    for (const int radius : {1, 2}) {
      const Image<float> in = picture(rows, 9);
      Image<float> mean, turned;
      box_mean(in, radius, mean, pool);
      box_mean(on_its_side(in), radius, turned, pool);
      INFO(rows << " rows, radius " << radius);
      CHECK(std::ranges::equal(on_its_side(turned).samples(), mean.samples()));
    }
}

TEST_CASE("rows are mirrored at the border, and again where a picture ends before") {
  CHECK(mirrored_row(-2, 5) == 2);
  CHECK(mirrored_row(6, 5) == 2);
  CHECK(mirrored_row(-1, 2) == 1);
  CHECK(mirrored_row(-2, 2) == 0);
  CHECK(mirrored_row(2, 2) == 0);
  CHECK(mirrored_row(-2, 1) == 0);
  CHECK(mirrored_row(2, 1) == 0);
}
