#include "hal/recording/nominal_rate.h"

#include <limits>
#include <utility>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a rate as users name it, or of a rounded interval, is the nominal one") {
  for (const auto& [hz, nominal] : {std::pair(29.97, NominalRate{30000, 1001}),
                                    {23.976, {24000, 1001}},
                                    {59.94, {60000, 1001}},
                                    {119.88, {120000, 1001}},
                                    {30000 / 1001.0, {30000, 1001}},
                                    {1 / 0.033366667, {30000, 1001}},
                                    {1 / 0.033333333, {30, 1}},
                                    {1 / 0.016667, {60, 1}},
                                    {25.0, {25, 1}},
                                    {1000.0, {1000, 1}}}) {
    CAPTURE(hz);
    CHECK(nominal_rate(hz) == nominal);
  }
}

TEST_CASE("any other rate is the nearest fraction") {
  CHECK(nominal_rate(0.1) == NominalRate{1, 10});
  CHECK(nominal_rate(12.5) == NominalRate{25, 2});
  CHECK(nominal_rate(29.9) == NominalRate{299, 10});
  CHECK(nominal_rate(25.974) == NominalRate{12987, 500});  // nobody means 26000 / 1001
}

TEST_CASE("what is no rate stays none") {
  CHECK(nominal_rate(0) == NominalRate{0, 1});
  CHECK(nominal_rate(-30) == NominalRate{-30, 1});
  CHECK(nominal_rate(std::numeric_limits<double>::quiet_NaN()) == NominalRate{0, 0});
}
