// A cycle that follows the light, on a sensor whose pictures really change with it.
#include "capture/exposure_adaptation.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "capture/capture_stage.h"
#include "tests/capture/sensor_model.h"

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};

struct Followed {
  CaptureCounters counters;
  SlotShares first[3], last[3];  // of the first and the last frame of each slot
  Duration shortest{0}, longest{0};
  int wrong = 0;  // trusted labels that are not the exposure the sensor had
};

// key: how bright the scene is, see SensorSettings.
Followed follow(double key, Adapt adapt) {
  test::SensorModel sensor({.kind = test::SensorKind::Gamma8, .pan_px = 1, .key = key}, {});
  CaptureOptions options;
  options.adapt = adapt;
  auto opened = CaptureStage::open(sensor, nullptr, kCycle, Mains::Off, options);
  REQUIRE(opened.ok());
  CaptureStage& stage = **opened;
  REQUIRE(stage.start().ok());
  Followed seen;
  CapturedFrame frame;
  for (int i = 0; i < 600; ++i) {
    REQUIRE(stage.next(frame).ok());
    const int slot = frame.raw.facts.slot;
    if (slot < 0) continue;
    if (frame.proof.trusted()) seen.wrong += std::abs(frame.proof.label.log_value() - sensor.truth()) > 0.1;
    if (i < 12) seen.first[slot] = frame.shares;
    seen.last[slot] = frame.shares;
  }
  seen.counters = stage.counters();
  seen.shortest = stage.schedule().slot(0).exposure.time;
  seen.longest = stage.schedule().slot(2).exposure.time;
  return seen;
}

TEST_CASE("a scene that is too bright shortens the cycle until highlights are kept", "[capture]") {
  const Followed seen = follow(6, Adapt::Light);
  INFO("shortest " << describe(seen.shortest) << ", clipped " << seen.first[0].clipped << " -> "
                   << seen.last[0].clipped);
  CHECK(seen.first[0].clipped > 0.05f);
  CHECK(seen.last[0].clipped < 0.02f);
  CHECK(seen.shortest < 1ms);
  CHECK(seen.counters.cycle_changes >= 1);
  CHECK(seen.wrong == 0);
}

TEST_CASE("a scene that is too dark lengthens the cycle until shadows are kept, or the frame is full",
          "[capture]") {
  const Followed seen = follow(0.01, Adapt::Light);
  INFO("longest " << describe(seen.longest) << ", dark " << seen.first[2].dark << " -> "
                  << seen.last[2].dark);
  CHECK(seen.first[2].dark > 0.05f);
  CHECK(seen.last[2].dark < seen.first[2].dark);
  CHECK(seen.longest > 16ms);
  CHECK(seen.wrong == 0);
}

TEST_CASE("a cycle that suits the scene rests, and one that may not follow stays", "[capture]") {
  const Followed still = follow(6, Adapt::Off);
  CHECK(still.shortest == 1ms);
  CHECK(still.counters.cycle_changes == 0);

  ExposureAdaptation adaptation(kCycle, 100us, 30ms, 8);
  for (int i = 0; i < 300; ++i)
    REQUIRE_FALSE(adaptation.observe(i % 3, {i % 3 == 0 ? 0.005f : 0.2f, i % 3 == 2 ? 0.02f : 0.3f}));
}

TEST_CASE("it waits until the new cycle is back before it judges again", "[capture]") {
  ExposureAdaptation adaptation(kCycle, 100us, 30ms, 8);
  int changes = 0, first = -1, second = -1;
  for (int i = 0; i < 60; ++i)
    if (adaptation.observe(i % 3, {0.5f, 0})) (changes++ == 0 ? first : second) = i;
  CHECK(first == 11);
  CHECK(second == 11 + 15 + 12);
}

}  // namespace
}  // namespace hdrcam
