#include "online/pictures/local_statistics.h"

#include <algorithm>
#include <cmath>

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

TEST_CASE("box means and local contrast agree with sums written out", "[isa]") {
  WorkerPool pool(2);
  Image<float> image(3, 9, 11);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 11; ++x)
        image.at(c, y, x) = 2 + static_cast<float>(std::sin(0.31 * x + c) * std::cos(0.23 * y));
  Image<float> mean, contrast, small, large;
  box_mean(image, 1, small, pool);
  box_mean(image, 2, large, pool);
  local_contrast(image, mean, contrast, pool);
  const auto mirrored = [](int i, int n) { return i < 0 ? -i : i >= n ? 2 * n - 2 - i : i; };
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 11; ++x) {
      double sum[3] = {}, square = 0;
      for (int r = 1; r <= 2; ++r)
        for (int dy = -r; dy <= r; ++dy)
          for (int dx = -r; dx <= r; ++dx) {
            const auto v = static_cast<double>(image.at(2, mirrored(y + dy, 9), mirrored(x + dx, 11)));
            sum[r] += v;
            if (r == 1) square += v * v;
          }
      REQUIRE(small.at(2, y, x) == Approx(sum[1] / 9));
      REQUIRE(large.at(2, y, x) == Approx(sum[2] / 25));
      REQUIRE(mean.at(2, y, x) == Approx(sum[1] / 9));
      REQUIRE(contrast.at(2, y, x) == Approx(square / 9 - sum[1] / 9 * sum[1] / 9).margin(1e-5));
    }
}
