// A cycle that follows the light, on a sensor whose pictures really change with it.
#include "capture/exposure_adaptation.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "capture/capture_stage.h"
#include "tests/capture/misbehaving_camera.h"
#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};

const ExposureLimits kLimits{.cycle = {std::begin(kCycle), std::end(kCycle)},
                             .shortest = 100us,
                             .longest = 30ms,
                             .least_gain = 1,
                             .greatest_gain = 8};
constexpr int kLatency_frames = 8;

std::unique_ptr<CaptureStage> started(Camera& sensor, std::span<const Exposure> cycle, Adapt adapt) {
  CaptureOptions options;
  options.adapt = adapt;
  auto opened = CaptureStage::open(sensor, nullptr, cycle, Mains::Off, options);
  REQUIRE(opened.ok());
  REQUIRE((*opened)->start().ok());
  return std::move(*opened);
}

struct Followed {
  CaptureCounters counters;
  SlotShares first[3], last[3];  // of the first and the last frame of each slot
  Duration shortest{0}, longest{0};
  int wrong = 0;  // trusted labels that are not the exposure the sensor had
};

// key: how bright the scene is, see SensorSettings.
Followed follow(double key, Adapt adapt, double gain = 1) {
  test::MisbehavingCamera sensor(
      {.kind = test::SensorKind::Gamma8, .pan_px = 1, .least_gain = gain, .key = key}, {});
  std::vector<Exposure> cycle(std::begin(kCycle), std::end(kCycle));
  for (Exposure& exposure : cycle) exposure.gain = gain;
  const auto running = started(sensor, cycle, adapt);
  CaptureStage& stage = *running;
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

TEST_CASE("a sensor that always amplifies follows the light, too", "[capture]") {
  const Followed bright = follow(6, Adapt::Light, 1.5), dark = follow(0.01, Adapt::Light, 1.5);
  CHECK(bright.counters.cycle_changes >= 1);
  CHECK(bright.last[0].clipped < 0.02f);
  CHECK(dark.counters.cycle_changes >= 1);
  CHECK(dark.longest > 16ms);
  CHECK(bright.wrong + dark.wrong == 0);
}

TEST_CASE("a cycle too dark for any label follows the light until pictures tell the exposures", "[capture]") {
  constexpr Exposure kDark[] = {{20us, 1}, {40us, 1}, {80us, 1}};
  test::MisbehavingCamera sensor({.kind = test::SensorKind::Gamma8,
                                  .per_request = false,
                                  .latency = 2,
                                  .gain_latency = 2,
                                  .reports = false,
                                  .pan_px = 1,
                                  .key = 0.1},
                                 {});
  const auto running = started(sensor, kDark, Adapt::Light);
  CaptureStage& stage = *running;
  CapturedFrame frame;
  int trusted_first = 0, trusted_last = 0, wrong = 0;
  for (int i = 0; i < 900; ++i) {
    REQUIRE(stage.next(frame).ok());
    if (!frame.proof.trusted()) continue;
    (i < 60 ? trusted_first : trusted_last) += 1;
    wrong += std::abs(frame.proof.label.log_value() - sensor.truth()) > 0.1 ? 1 : 0;
  }
  INFO("longest " << describe(stage.schedule().slot(2).exposure.time) << ", trusted " << trusted_first
                  << " and " << trusted_last);
  CHECK(trusted_first == 0);
  CHECK(stage.schedule().slot(2).exposure.time > 1ms);
  CHECK(trusted_last > 200);
  CHECK(wrong == 0);
}

TEST_CASE("a cycle that repeats an exposure follows the light, also where the control delays are unknown",
          "[capture]") {
  constexpr Exposure kRepeats[] = {{1ms, 1}, {16ms, 1}, {1ms, 1}};
  for (int latency = 0; latency <= 3; ++latency) {
    test::MisbehavingCamera sensor({.kind = test::SensorKind::Gamma8,
                                    .per_request = false,
                                    .latency = latency,
                                    .gain_latency = latency,
                                    .reports = true,
                                    .pan_px = 1,
                                    .key = 6},
                                   {});
    const auto running = started(sensor, kRepeats, Adapt::Light);
    CaptureStage& stage = *running;
    CapturedFrame frame;
    for (int i = 0; i < 300; ++i) REQUIRE(stage.next(frame).ok());
    const auto time = [&](int slot) { return stage.schedule().slot(slot).exposure.time; };
    INFO("latency " << latency);
    CHECK(stage.counters().cycle_changes >= 1);
    CHECK(time(0) < 1ms);
    CHECK(time(2) == time(0));
    CHECK(time(1) > time(0));
  }
}

TEST_CASE("a cycle that suits the scene rests, and one that may not follow stays", "[capture]") {
  const Followed still = follow(6, Adapt::Off);
  CHECK(still.shortest == 1ms);
  CHECK(still.counters.cycle_changes == 0);

  ExposureAdaptation adaptation(kLimits, kLatency_frames);
  for (int i = 0; i < 300; ++i)
    REQUIRE_FALSE(adaptation.observe(i % 3, {i % 3 == 0 ? 0.005f : 0.2f, i % 3 == 2 ? 0.02f : 0.3f}));
}

TEST_CASE(
    "a cycle of two near exposures follows the light, and one of a single exposure has no range to move",
    "[capture]") {
  ExposureLimits limits = kLimits;
  limits.cycle = {{28ms, 1}, {30ms, 1}};
  ExposureAdaptation near_ones(limits, kLatency_frames);
  std::optional<ExposureSchedule::Cycle> next;
  for (int i = 0; i < 20 && !next; ++i) next = near_ones.observe(i % 2, {0.5f, 0});
  REQUIRE(next.has_value());
  CHECK((*next)[0].time == 14ms);

  limits.cycle = {{4ms, 1}};
  ExposureAdaptation single(limits, kLatency_frames);
  for (int i = 0; i < 20; ++i) CHECK_FALSE(single.observe(0, {0.5f, 0}));
}

TEST_CASE("the darkest and the brightest frames move the cycle where nobody knows their exposures",
          "[capture]") {
  const auto asked = [](const SlotShares& most, const SlotShares& every_fifth) {
    ExposureAdaptation adaptation(kLimits, kLatency_frames);
    std::optional<ExposureSchedule::Cycle> next;
    for (int i = 0; i < 60 && !next; ++i) next = adaptation.observe(-1, i % 5 == 0 ? every_fifth : most);
    return next;
  };
  const SlotShares black{0, 0.99f}, white{0.99f, 0}, fair{0.002f, 0.02f};
  const auto longer = asked(black, black), shorter = asked(white, white), wider = asked(black, white);
  REQUIRE((longer && shorter && wider));
  CHECK(((*longer)[0].time > 1ms && (*longer)[2].time > 16ms));
  CHECK(((*shorter)[0].time < 1ms && (*shorter)[2].time < 16ms));
  CHECK(((*wider)[0].time > 1ms && (*wider)[2].time < 16ms));
  const auto lifted = asked(fair, black);
  REQUIRE(lifted.has_value());
  CHECK(((*lifted)[0].time > 1ms && (*lifted)[2].time == 16ms));
  CHECK_FALSE(asked(fair, {0.005f, 0.3f}));

  ExposureAdaptation adaptation(kLimits,
                                kLatency_frames);  // a frame of which it is known begins the count anew
  for (int i = 0; i < 200; ++i) REQUIRE_FALSE(adaptation.observe(i % 20 == 0 ? 1 : -1, black));
}

TEST_CASE("it waits until the new cycle is back before it judges again", "[capture]") {
  ExposureAdaptation adaptation(kLimits, kLatency_frames);
  int frames = 0;
  const auto until_change = [&] {
    for (int begin = frames; frames < begin + 100; ++frames)
      if (const auto cycle = adaptation.observe(frames % 3, {0.5f, 0})) return *cycle;
    FAIL("no change");
    return ExposureSchedule::Cycle{};
  };
  const auto first = until_change();
  const int before_first = frames;
  adaptation.runs(first);
  ++frames;
  const auto second = until_change();
  CHECK(frames - before_first > before_first);
  CHECK(second[0].time < first[0].time);
}

TEST_CASE(
    "frames of the cycle before, of no exposure of the new one, are waited for however many are queued") {
  constexpr Exposure kTwo[] = {{1ms, 1}, {2ms, 1}};
  test::MisbehavingCamera sensor({.kind = test::SensorKind::Gamma8,
                                  .per_request = false,
                                  .latency = 2,
                                  .gain_latency = 2,
                                  .reports = true,
                                  .pan_px = 1,
                                  .key = 100},
                                 {});
  CaptureOptions options;
  options.adapt = Adapt::Light, options.buffers = 32, options.delays = ControlDelays{2, 2};
  const auto running = value_of(CaptureStage::open(sensor, nullptr, kTwo, Mains::Off, options));
  CaptureStage& stage = *running;
  require_done(stage.start());
  CapturedFrame frame;
  for (int i = 0; i < 60 && stage.counters().cycle_changes == 0; ++i) require_done(stage.next(frame));
  REQUIRE(stage.counters().cycle_changes == 1);
  const ExposureSchedule second = stage.schedule();
  for (int slot = 0; slot < 2; ++slot) REQUIRE(second.slot(slot).exposure.time < kTwo[slot].time);
  const auto is_of_second = [&](double log_exposure) {
    return std::abs(log_product(second.slot(0).exposure) - log_exposure) < 0.01 ||
           std::abs(log_product(second.slot(1).exposure) - log_exposure) < 0.01;
  };
  int frames = 0;
  do {
    require_done(stage.next(frame));
    REQUIRE(++frames < 60);
  } while (!is_of_second(sensor.truth()));
  CHECK(frames > 30);
  CHECK(stage.counters().cycle_changes == 1);
}

TEST_CASE("frames of the cycle before say nothing of the one that follows darkness", "[capture]") {
  ExposureAdaptation adaptation(kLimits, kLatency_frames);
  for (int i = 0; i < 9; ++i)
    REQUIRE_FALSE(adaptation.observe(i % 3, {0.5f, 0}));  // too few, then it is dark
  std::optional<ExposureSchedule::Cycle> next;
  for (int i = 0; i < 60 && !next; ++i) next = adaptation.observe(-1, {0, 0.99f});
  REQUIRE(next.has_value());
  adaptation.runs(*next);
  for (int i = 0; i < 300; ++i)
    REQUIRE_FALSE(adaptation.observe(i % 3, {i % 3 == 0 ? 0.005f : 0.2f, i % 3 == 2 ? 0.02f : 0.3f}));
}

TEST_CASE("a cycle that the camera refuses is not taken for the one that runs", "[capture]") {
  ExposureAdaptation adaptation(kLimits, kLatency_frames);
  std::vector<ExposureSchedule::Cycle> asked;
  for (int i = 0; i < 60; ++i)
    if (const auto cycle = adaptation.observe(i % 3, {0.5f, 0})) asked.push_back(*cycle);
  REQUIRE(asked.size() >= 3);
  for (const auto& cycle : asked) CHECK(cycle[0].time == 500us);  // a stop below the one that runs, each time
}

}  // namespace
}  // namespace hdrcam
