#include "online/response/float_order.h"

#include <algorithm>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("numbers are put in order by their bits as comparisons would put them") {
  std::mt19937 random(3);
  std::vector<float> scratch;
  for (const std::size_t n : {0u, 1u, 2u, 7u, 1000u, 70'000u}) {
    std::vector<float> values(n);
    for (float& v : values) v = std::uniform_real_distribution<float>(-300, 300)(random);
    for (std::size_t i = 0; i < n; i += 3) values[i] = std::round(values[i]);  // many are equal
    if (n > 100) {
      values[5] = std::numeric_limits<float>::infinity(), values[6] = -std::numeric_limits<float>::infinity();
      values[7] = 1e-42f, values[8] = -1e-42f, values[9] = 0;
    }
    std::vector<float> expected = values;
    std::sort(expected.begin(), expected.end());
    sort_floats(values, scratch);
    CHECK(values == expected);
  }
}

TEST_CASE("whole codes, whose last digits are all alike, are put in order, too") {
  std::mt19937 random(4);
  std::vector<float> values(3000), scratch;
  for (float& v : values) v = static_cast<float>(std::uniform_int_distribution<int>(0, 255)(random));
  std::vector<float> expected = values;
  std::sort(expected.begin(), expected.end());
  sort_floats(values, scratch);
  CHECK(values == expected);
}
