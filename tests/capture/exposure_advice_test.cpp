#include "capture/exposure_advice.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};

TEST_CASE("clipped highlights shorten the short end, lost shadows lengthen the long end", "[capture]") {
  const SlotShares content[] = {{0.005f, 0.3f}, {0.1f, 0.1f}, {0.3f, 0.02f}};
  CHECK_FALSE(advise(kCycle, content).changes());

  const SlotShares bright[] = {{0.05f, 0.1f}, {0.2f, 0.05f}, {0.5f, 0.02f}};
  const ExposureAdvice shorter = advise(kCycle, bright);
  CHECK(shorter.stops[0] == -1);
  CHECK(shorter.stops[1] == Approx(-0.5));
  CHECK(shorter.stops[2] == 0);

  const SlotShares dark[] = {{0, 0.5f}, {0, 0.4f}, {0.01f, 0.2f}};
  const ExposureAdvice longer = advise(kCycle, dark);
  CHECK(longer.stops[0] == 0);
  CHECK(longer.stops[2] == 1);
}

TEST_CASE("a range that is wider than the scene is drawn in again", "[capture]") {
  const SlotShares wasted[] = {{0, 0.95f}, {0.2f, 0.1f}, {0.7f, 0}};
  const ExposureAdvice advice = advise(kCycle, wasted);
  CHECK(advice.stops[0] > 0);
  CHECK(advice.stops[2] < 0);
}

TEST_CASE("advice is followed by time first, then by gain", "[capture]") {
  ExposureAdvice advice;
  advice.stops = {-1, 0, 1};
  ExposureLimits limits{.cycle = {}, .shortest = 100us, .longest = 20ms, .least_gain = 1, .greatest_gain = 8};
  const auto next = followed(kCycle, advice, limits);
  CHECK(next[0] == Exposure{500us, 1});
  CHECK(next[1] == kCycle[1]);
  CHECK(next[2].time == 20ms);
  CHECK(next[2].gain == Approx(1.6));

  limits.least_gain = 1.25;  // a sensor that always amplifies: less time instead
  const auto amplified = followed(kCycle, advice, limits);
  CHECK(amplified[0] == Exposure{400us, 1.25});
  CHECK(amplified[1].product() == Approx(kCycle[1].product()));
  CHECK(amplified[2].gain == Approx(1.6));

  limits.shortest = 800us;
  CHECK(followed(kCycle, advice, limits)[0] == Exposure{800us, 1.25});
}

TEST_CASE("a cycle of one has no range to move", "[capture]") {
  const SlotShares shares[] = {{0.5f, 0}};
  CHECK_FALSE(advise(std::span(kCycle).first(1), shares).changes());
}

}  // namespace
}  // namespace hdrcam
