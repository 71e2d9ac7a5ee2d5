#include "capture/exposure_advice.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};

TEST_CASE("clipped highlights shorten the short end, lost shadows lengthen the long end", "[capture]") {
  CHECK_FALSE(advise({0.005f, 0.3f}, {0.3f, 0.02f}).changes());

  const ExposureAdvice shorter = advise({0.05f, 0.1f}, {0.5f, 0.02f});
  CHECK(shorter.shortest == -1);
  CHECK(shorter.longest == 0);

  const ExposureAdvice longer = advise({0, 0.5f}, {0.01f, 0.2f});
  CHECK(longer.shortest == 0);
  CHECK(longer.longest == 1);
}

TEST_CASE("a range that is wider than the scene is drawn in again", "[capture]") {
  const ExposureAdvice advice = advise({0, 0.95f}, {0.7f, 0});
  CHECK(advice.shortest > 0);
  CHECK(advice.longest < 0);
}

ExposureLimits limits_of(std::vector<Exposure> cycle, double greatest_gain = 1) {
  return {.cycle = std::move(cycle),
          .shortest = 100us,
          .longest = 32ms,
          .least_gain = 1,
          .greatest_gain = greatest_gain};
}

double stops_between(const Exposure& a, const Exposure& b) { return std::log2(b.product() / a.product()); }

TEST_CASE("advice is followed by time first, then by gain", "[capture]") {
  const ExposureAdvice advice{-1, 1};
  ExposureLimits limits = limits_of({std::begin(kCycle), std::end(kCycle)}, 8);
  limits.longest = 20ms;
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

TEST_CASE("an end at its limit leaves the exposures between in their place, and light brings all back",
          "[capture]") {
  const ExposureLimits limits = limits_of({std::begin(kCycle), std::end(kCycle)});
  ExposureSchedule::Cycle cycle = followed(kCycle, {0, 1}, limits);
  for (int i = 0; i < 10; ++i) cycle = followed(cycle, {0, 1}, limits);  // a dim room
  CHECK(cycle[2].time == 32ms);
  CHECK(stops_between(cycle[0], cycle[1]) == Approx(stops_between(cycle[1], cycle[2])).margin(1e-3));
  for (int i = 0; i < 3; ++i) cycle = followed(cycle, {-1, 0}, limits);
  CHECK(stops_between(cycle[0], cycle[1]) == Approx(stops_between(cycle[1], cycle[2])).margin(1e-3));
}

TEST_CASE("the ends of a cycle come no closer than a stop for each step, and part again", "[capture]") {
  const ExposureLimits limits = limits_of({std::begin(kCycle), std::end(kCycle)});
  ExposureSchedule::Cycle cycle = followed(kCycle, {0.5f, 1}, limits);
  for (int i = 0; i < 20; ++i) cycle = followed(cycle, {0.5f, 1}, limits);  // the lens is covered
  CHECK(cycle[2].time == 32ms);
  CHECK(stops_between(cycle[0], cycle[2]) == Approx(2).margin(1e-3));
  cycle = followed(cycle, {-1, 0}, limits);
  CHECK(stops_between(cycle[0], cycle[2]) == Approx(3).margin(1e-3));
  for (int i = 0; i < 20; ++i) cycle = followed(cycle, {-1, -0.5f}, limits);  // the sun
  CHECK(cycle[0].time == 100us);
  CHECK(stops_between(cycle[0], cycle[2]) == Approx(2).margin(1e-3));

  // those who asked for less have it
  const Exposure narrow[] = {{30ms, 1}, {32ms, 1}};
  const auto wider = followed(narrow, {-1, 0}, limits_of({std::begin(narrow), std::end(narrow)}));
  CHECK(wider[0].time == 15ms);
  CHECK(wider[1].time == 32ms);
}

}  // namespace
}  // namespace hdrcam
