#include "render/scores/order_statistics.h"

#include <catch2/catch.hpp>

namespace hdrcam {

TEST_CASE("percentiles and medians are numpy's") {
  const std::vector<float> samples{3, 1, 4, 1, 5, 9, 2, 6, 5, 3.5f};
  const auto at = [&](double percent) {
    std::vector<float> copy = samples;
    return percentile(copy, percent);
  };
  REQUIRE(at(0) == 1);
  REQUIRE(at(10) == 1);
  REQUIRE(at(50) == 3.75);
  REQUIRE(at(99.9) == Approx(8.973));
  REQUIRE(at(100) == 9);
  std::vector<float> odd(samples.begin(), samples.end() - 1);
  REQUIRE(numpy_median(odd) == 4);
  std::vector<float> one{7};
  REQUIRE(percentile(one, 99.9) == 7);
}

}  // namespace hdrcam
