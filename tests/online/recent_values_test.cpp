#include "online/recent_values.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the greatest and the least of a stream are those of its newest values alone") {
  constexpr int kMany = 40, kKept = static_cast<int>(RecentValues::kKept);
  RecentValues rising, falling;
  for (int i = 1; i <= kMany; ++i) {
    rising.add(static_cast<float>(i)), falling.add(static_cast<float>(-i));
    const int oldest = i > kKept ? i - kKept + 1 : 1;
    CAPTURE(i);
    CHECK(rising.greatest(0) == static_cast<float>(i));
    CHECK(rising.least(0) == static_cast<float>(oldest));
    CHECK(falling.greatest(0) == static_cast<float>(-oldest));
    CHECK(falling.least(0) == static_cast<float>(-i));
  }
}

TEST_CASE("a stream without values has what is said instead, also after it was cleared") {
  RecentValues values;
  CHECK(values.greatest(7) == 7);
  CHECK(values.least(-7) == -7);
  for (int i = 0; i < 50; ++i) values.add(100);
  values.clear();
  CHECK(values.greatest(7) == 7);
  values.add(3);
  CHECK(values.greatest(7) == 3);
  CHECK(values.least(-7) == 3);
}
