// Which black level is claimed, for misfits that a test states.
#include "online/response/black_level_search.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace hdrcam;

namespace {

constexpr float kDarkest = 6, kMost = 30;

}  // namespace

TEST_CASE("a black level above the darkest pixels is the matches' word, not that of usual curves") {
  // above the darkest pixels the curve would be a usual one, and the pictures match as well as elsewhere
  const auto usual_above = [](float level) { return CurveMisfit{100, level > kDarkest ? 0.0 : 200.0}; };
  CHECK(find_black_level(kDarkest, kMost, usual_above) == 0);
  const auto matching_above = [](float level) { return CurveMisfit{level > kDarkest ? 0.0 : 100.0, 200}; };
  CHECK(find_black_level(kDarkest, kMost, matching_above) > kDarkest);
}

TEST_CASE("up to the darkest pixels usual curves have a word, too") {
  const auto usual_at_darkest = [](float level) { return CurveMisfit{100, level == kDarkest ? 0.0 : 200.0}; };
  CHECK(find_black_level(kDarkest, kMost, usual_at_darkest) == kDarkest);
}

TEST_CASE("no black level is claimed for less than it costs") {
  const auto hardly_better = [](float level) { return CurveMisfit{level > 0 ? 95.0 : 100.0, 0}; };
  CHECK(find_black_level(kDarkest, kMost, hardly_better) == 0);
}

TEST_CASE(
    "beside two channels that have a black level the third has one, unless its matches tell against it") {
  constexpr OtherBlackLevels kOthers{2, 5};
  const auto silent = [](float) { return CurveMisfit{1, 1}; };
  CHECK(find_black_level(kDarkest, kMost, silent) == 0);
  CHECK(std::abs(find_black_level(kDarkest, kMost, silent, kOthers) - kOthers.mean) < 1);
  const auto worse = [](float level) { return CurveMisfit{level > 0 ? 100.0 : 1.0, 1}; };
  CHECK(find_black_level(kDarkest, kMost, worse, kOthers) == 0);
}

TEST_CASE("beside one channel that has a black level another has the like if its matches are for it at all") {
  constexpr OtherBlackLevels kOther{1, 5};
  const auto hardly_better = [](float level) { return CurveMisfit{level > 0 ? 98.0 : 100.0, 0}; };
  CHECK(std::abs(find_black_level(kDarkest, kMost, hardly_better, kOther) - kOther.mean) < 2);
  CHECK(find_black_level(kDarkest, kMost, hardly_better, {1, 24}) == 0);  // unlike what it may have
  const auto hardly_worse = [](float level) { return CurveMisfit{level > 0 ? 102.0 : 100.0, 0}; };
  CHECK(find_black_level(kDarkest, kMost, hardly_worse, kOther) == 0);
}
