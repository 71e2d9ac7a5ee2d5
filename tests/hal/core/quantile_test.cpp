#include "hal/core/quantile.h"

#include <array>
#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a quantile is the value whose rank is the share of the last one's, rounded down") {
  std::vector<int> values{50, 10, 40, 20, 30};
  CHECK(quantile(std::span(values), 0.0) == 10);
  CHECK(quantile(std::span(values), 0.5) == 30);
  CHECK(quantile(std::span(values), 0.74) == 30);
  CHECK(quantile(std::span(values), 0.75) == 40);
  CHECK(quantile(std::span(values), 1.0) == 50);
  CHECK(quantile(std::span<int>(), 0.5) == 0);
}

TEST_CASE("a quantile may be of some of the values only, and in another order") {
  std::array<double, 6> values{3, 1, 2, 5, -100, 100};
  CHECK(quantile(std::span(values).first(4), 0.75) == 3);
  CHECK(values[4] == -100);
  CHECK(quantile(std::span(values).first(4), 0.75, std::greater<>()) == 2);
}
