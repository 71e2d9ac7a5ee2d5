// The proof of exposure, end to end: a sensor that misbehaves in every way that we know of, and a stage that
// must never call a wrong label proved.
#include "capture/capture_stage.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "hal/sim/sim_bench.h"
#include "tests/capture/misbehaving_camera.h"

namespace hdrcam {
namespace {

using test::MisbehavingCamera;
using test::SensorFaults;
using test::SensorKind;
using test::SensorSettings;
using test::StrobeModel;
using namespace std::chrono_literals;

constexpr Exposure kOne[] = {{4ms, 1}};
constexpr Exposure kTwo[] = {{2ms, 1}, {16ms, 1}};
constexpr Exposure kThree[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};
constexpr Exposure kFour[] = {{1ms, 1}, {4ms, 1}, {8ms, 1}, {8ms, 4}};

std::span<const Exposure> cycle_of(int slots) {
  switch (slots) {
    case 1:
      return kOne;
    case 2:
      return kTwo;
    case 3:
      return kThree;
    default:
      return kFour;
  }
}

struct Tally {
  int frames = 0, proved = 0, plausible = 0, contradicted = 0, unknown = 0, relabelled = 0;
  int proved_wrong = 0;        // of another slot, or further off than the proof says
  int trusted_wrong = 0;       // proved or plausible, and of another slot
  int trusted_wrong_late = 0;  // of them, after the first three rounds
  int slots_wrong = 0;
  CaptureCounters counters;
};

int nearest_slot(std::span<const Exposure> cycle, double value) {
  const auto distance = [&](const Exposure& exposure) { return std::abs(log_product(exposure) - value); };
  return static_cast<int>(
      std::min_element(cycle.begin(), cycle.end(),
                       [&](const Exposure& a, const Exposure& b) { return distance(a) < distance(b); }) -
      cycle.begin());
}

void judge(const CapturedFrame& frame, double truth, std::span<const Exposure> cycle, Tally& tally) {
  const Judgement& proof = frame.proof;
  ++tally.frames;
  tally.proved += proof.verdict == Verdict::Proved;
  tally.plausible += proof.verdict == Verdict::Plausible;
  tally.contradicted += proof.verdict == Verdict::Contradicted;
  tally.unknown += proof.verdict == Verdict::Unknown;
  tally.relabelled += proof.relabelled;
  REQUIRE(proof.trusted() == ((frame.raw.facts.flags & kFrameExposureUnproved) == 0));
  if (!proof.trusted()) return;

  const double label = proof.label.log_value();
  REQUIRE(std::abs(std::log(frame.raw.facts.exposure()) - label) < 1e-6);
  const bool wrong = nearest_slot(cycle, truth) != nearest_slot(cycle, label);
  tally.trusted_wrong += wrong;
  tally.trusted_wrong_late += wrong && tally.frames > 3 * static_cast<int>(cycle.size());
  tally.slots_wrong += frame.raw.facts.slot >= 0 && frame.raw.facts.slot != nearest_slot(cycle, label);
  const bool beyond = std::abs(truth - label) > proof.within_ev * std::numbers::ln2 + 1e-9;
  tally.proved_wrong += proof.verdict == Verdict::Proved && (wrong || beyond);
}

Tally run(const SensorSettings& settings, const SensorFaults& faults, int slots, int frames,
          const CaptureOptions& options = {}) {
  const std::span<const Exposure> cycle = cycle_of(slots);
  MisbehavingCamera sensor(settings, faults);
  StrobeModel strobe(sensor);
  auto opened = CaptureStage::open(sensor, &strobe, cycle, Mains::Off, options);
  REQUIRE(opened.ok());
  CaptureStage& stage = **opened;
  REQUIRE(stage.start().ok());
  CapturedFrame frame;
  Tally tally;
  for (int i = 0; i < frames; ++i) {
    REQUIRE(stage.next(frame).ok());
    judge(frame, sensor.truth(), cycle, tally);
    const CaptureCounters& c = stage.counters();
    REQUIRE(c.captured == c.emitted + c.dropped());
    REQUIRE(c.emitted == c.proved + c.plausible + c.contradicted + c.unknown);
  }
  tally.counters = stage.counters();
  return tally;
}

std::string describe(const Tally& t) {
  return fmt::format(
      "{} frames: {} proved ({} wrong), {} plausible ({} relabelled), {} contradicted, {} unknown; trusted "
      "but wrong {}, {} of them late; lost {}, relocks {}",
      t.frames, t.proved, t.proved_wrong, t.plausible, t.relabelled, t.contradicted, t.unknown,
      t.trusted_wrong, t.trusted_wrong_late, t.counters.lost_by_camera, t.counters.relocks);
}

constexpr SensorKind kKinds[] = {SensorKind::RawBayer10, SensorKind::Gamma8, SensorKind::Film8};

TEST_CASE("a well-behaved camera has nearly all its frames proved, whatever its response", "[capture]") {
  for (const SensorKind kind : kKinds) {
    for (int slots = 2; slots <= 3; ++slots) {
      const Tally tally = run({.kind = kind, .pan_px = 1, .light_walk = 0.005}, {}, slots, 500);
      CAPTURE(static_cast<int>(kind), slots, describe(tally));
      CHECK(tally.proved_wrong == 0);
      CHECK(tally.proved >= 485);
      CHECK(tally.trusted_wrong == 0);
      CHECK(tally.contradicted + tally.unknown == 0);
      CHECK(tally.slots_wrong == 0);
    }
  }
}

TEST_CASE("no wrong label is ever proved over 10,000 frames with every fault at once", "[capture]") {
  const SensorFaults faults{.drop = 0.05,
                            .drop_run = 2,
                            .damage = 0.01,
                            .report_missing = 0.1,
                            .report_late = 0.05,
                            .cookie_doubled = 0.03,
                            .exposure_late = 0.03,
                            .exposure_early = 0.03,
                            .exposure_clipped = 0.03,
                            .slip = 0.005};
  const Tally tally = run({.reports = true, .light_walk = 0.02, .cut = 0.005}, faults, 3, 10'000);
  CAPTURE(describe(tally));
  CHECK(tally.proved_wrong == 0);
  CHECK(tally.proved > 6000);
  CHECK(tally.counters.damaged > 50);
  CHECK(tally.counters.lost_by_camera > 500);
  CHECK(tally.trusted_wrong < 20);
}

struct Fault {
  const char* name;
  SensorFaults faults;
  bool reports;
  int least_proved;  // of 300
};

TEST_CASE("no fault makes a wrong label proved", "[capture]") {
  const Fault kFaults[] = {
      {"one frame lost now and then", {.drop = 0.1}, false, 220},
      {"two frames lost at a time", {.drop = 0.1, .drop_run = 2}, false, 220},
      {"seven frames lost at a time, uncounted",
       {.drop = 0.1, .drop_run = 7, .hide_drops = true},
       false,
       165},
      {"frames lost that neither number nor time shows",
       {.drop = 0.1, .hide_drops = true, .freeze_time = true},
       false,
       190},
      {"half of all frames lost", {.drop = 0.5}, false, 190},
      {"reports missing", {.report_missing = 0.5}, true, 220},
      {"reports late", {.report_late = 0.3}, true, 140},
      {"requests completed twice", {.cookie_doubled = 0.2}, true, 190},
      {"exposures a frame late", {.exposure_late = 0.1}, false, 165},
      {"exposures a frame early", {.exposure_early = 0.1}, false, 165},
      {"exposures clipped now and then", {.exposure_clipped = 0.2}, false, 165},
      {"exposures clipped always", {.clips_always = true}, false, 0},
      {"exposures never applied", {.never_applied = true}, false, 0},
      {"exposures that slip for good", {.slip = 0.03}, false, 165},
  };
  for (const Fault& fault : kFaults) {
    for (int slots = 2; slots <= 4; ++slots) {
      const SensorKind kind = kKinds[(slots + (&fault - kFaults)) % 3];
      const Tally tally = run({.kind = kind, .reports = fault.reports}, fault.faults, slots, 300);
      CAPTURE(fault.name, slots, static_cast<int>(kind), describe(tally));
      CHECK(tally.proved_wrong == 0);
      CHECK(tally.proved >= fault.least_proved);
      if (fault.faults.never_applied) CHECK(tally.proved == 0);
      CHECK(tally.trusted_wrong_late <= 6);
    }
  }
}

struct HardScene {
  SensorSettings settings;
  int least_proved, least_trusted;  // of 400
};

// Where nearly all is black or clipped hardly anything can be proved: those scenes show that the stage trusts
// frames all the same.
TEST_CASE("a fast pan, cuts and unsteady light cost proofs, not truth", "[capture]") {
  for (const auto& [scene, least_proved, least_trusted] :
       {HardScene{{.pan_px = 12}, 130, 340}, HardScene{{.pan_px = 5, .cut = 0.05}, 140, 340},
        HardScene{{.light_walk = 0.1}, 140, 230}, HardScene{{.key = 0.1}, 260, 340},
        HardScene{{.key = 8}, 100, 340}, HardScene{{.key = 0.02}, 0, 340}, HardScene{{.key = 40}, 0, 340}}) {
    for (int slots = 2; slots <= 4; ++slots) {
      const Tally tally = run(scene, {.exposure_late = 0.1}, slots, 400);
      CAPTURE(scene.pan_px, scene.cut, scene.light_walk, scene.key, slots, describe(tally));
      CHECK(tally.proved_wrong == 0);
      CHECK(tally.proved >= least_proved);
      CHECK(tally.proved + tally.plausible >= least_trusted);
    }
  }
}

TEST_CASE("controls that act frames later are predicted and proved, for every delay", "[capture]") {
  for (int exposure = 0; exposure <= 3; ++exposure) {
    for (int gain = 0; gain <= 3; ++gain) {
      const SensorSettings settings{
          .per_request = false, .latency = exposure, .gain_latency = gain, .pan_px = 1};
      const Tally tally = run(settings, {}, 4, 120, {.delays = ControlDelays{exposure, gain}});
      CAPTURE(exposure, gain, describe(tally));
      CHECK(tally.proved_wrong == 0);
      CHECK(tally.proved >= 100);
      CHECK(tally.trusted_wrong == 0);
    }
  }
}

TEST_CASE("a wrong delay is found from the pictures within three rounds", "[capture]") {
  for (const int believed : {0, 1, 3, 4}) {
    const SensorSettings settings{.per_request = false, .latency = 2, .gain_latency = 2, .pan_px = 1};
    const Tally tally = run(settings, {.drop = 0.02}, 3, 200, {.delays = ControlDelays{believed, believed}});
    CAPTURE(believed, describe(tally));
    CHECK(tally.proved_wrong == 0);
    CHECK(tally.trusted_wrong_late == 0);
    CHECK(tally.proved >= 170);
    CHECK(tally.counters.relocks >= 1);
  }
}

TEST_CASE("a control that was written late makes no label wrong, not even in the dark", "[capture]") {
  for (const int latency : {0, 1, 3}) {
    SensorSettings settings{.per_request = false, .latency = latency, .gain_latency = latency, .pan_px = 1};
    const CaptureOptions options{.delays = ControlDelays{latency, latency}};
    const SensorFaults faults{.written_late = 0.1};
    const Tally bright = run(settings, faults, 3, 300, options);
    CAPTURE(latency, describe(bright));
    CHECK(bright.trusted_wrong == 0);
    CHECK(bright.proved + bright.plausible >= 285);
    CHECK(bright.relabelled >= 15);
    settings.key = 1e-4;
    const Tally dark = run(settings, faults, 3, 300, options);
    CAPTURE(describe(dark));
    CHECK(dark.trusted_wrong == 0);
    CHECK(dark.unknown >= 15);
    CHECK(dark.plausible >= 240);
  }
}

TEST_CASE("a camera that is slower or faster than it agreed loses no frames", "[capture]") {
  for (const Duration kept : {Duration(28ms), Duration(40ms), Duration(66ms), Duration(100ms)}) {
    const SensorSettings settings{
        .per_request = false, .latency = 2, .gain_latency = 2, .kept_frame = kept, .pan_px = 1};
    const Tally tally = run(settings, {}, 3, 200, {.delays = ControlDelays{2, 2}});
    CAPTURE(describe(tally));
    CHECK(tally.counters.lost_by_camera == 0);
    CHECK(tally.trusted_wrong == 0);
    CHECK(tally.proved >= 190);
    const Tally lossy =
        run(settings, {.drop = 0.1, .hide_drops = true}, 3, 200, {.delays = ControlDelays{2, 2}});
    CAPTURE(describe(lossy));
    CHECK(lossy.counters.lost_by_camera >= 10);
    CHECK(lossy.proved_wrong == 0);
  }
}

TEST_CASE("a camera about which nothing is known has its frames labelled by their pictures", "[capture]") {
  const SensorSettings settings{
      .kind = SensorKind::Gamma8, .per_request = false, .latency = 2, .gain_latency = 2, .pan_px = 1};
  const Tally tally = run(settings, {}, 3, 200);
  CAPTURE(describe(tally));
  CHECK(tally.proved == 0);
  CHECK(tally.plausible >= 180);
  CHECK(tally.unknown <= 20);
  CHECK(tally.trusted_wrong == 0);
}

TEST_CASE("a black level that comes with the frames proves as much as one of the table of sensors",
          "[capture]") {
  const SensorFaults faults{.drop = 0.05, .exposure_late = 0.05};
  for (const double key : {0.05, 1.0}) {
    const Tally of_table = run({.key = key}, faults, 3, 200);
    const Tally with_frames = run({.states_black = true, .key = key}, faults, 3, 200);
    CHECK(describe(with_frames) == describe(of_table));
  }
}

TEST_CASE("the strobe proves what pictures cannot: a cycle of one, and a scene in the dark", "[capture]") {
  const CaptureOptions options{.strobe = StrobePulse::SpansExposure, .strobe_after_timestamp = 2ms};
  const SensorSettings dark{.strobe_offset = 2ms, .key = 1e-4};
  const Tally three = run(dark, {.exposure_late = 0.1, .strobe_lost = 0.05}, 3, 300, options);
  CAPTURE(describe(three));
  CHECK(three.proved_wrong == 0);
  CHECK(three.proved >= 230);
  CHECK(three.relabelled >= 10);

  const Tally one = run({.strobe_offset = 2ms}, {}, 1, 100, options);
  CHECK(one.proved == 100);
  const Tally one_without = run({}, {}, 1, 100);
  CHECK(one_without.proved == 0);
  CHECK(one_without.plausible == 100);
  const Tally embedded = run({.reports = true, .embedded = true}, {}, 1, 100);
  CHECK(embedded.proved >= 95);
}

TEST_CASE("a strobe proves no wrong gain where the control delay that is given is wrong for the time alone",
          "[capture]") {
  for (const int latency : {1, 2, 3})
    for (const double key : {0.05, 1.0, 3.0, 8.0}) {
      const SensorSettings settings{
          .per_request = false, .latency = latency, .strobe_offset = 2ms, .key = key};
      const CaptureOptions options{
          .delays = ControlDelays{3, 0}, .strobe = StrobePulse::SpansExposure, .strobe_after_timestamp = 2ms};
      const Tally tally = run(settings, {}, 4, 200, options);
      CAPTURE(latency, key, describe(tally));
      CHECK(tally.proved_wrong == 0);
      if (latency == 3)
        CHECK(tally.proved >= (key < 5 ? 140 : 80));  // right; most of a bright one is clipped
    }
}

TEST_CASE("after the program was held up, labels are right also where pictures are too dark to tell",
          "[capture]") {
  constexpr Exposure kShort[] = {{10us, 1}, {40us, 1}, {160us, 1}};
  VirtualClock clock;
  const auto scene = simulation_of("night?size=64x48&fps=60&reports=no&delay=3,3&with=control-delay");
  REQUIRE(scene.ok());
  SimulatedCamera camera(scene.value(), SimTime(clock), 1);
  auto stage = CaptureStage::open(
      camera, nullptr, kShort, Mains::Off,
      {.mode = {.format = PixelFormat::Rgb24}, .delays = ControlDelays{3, 3}, .clock = &clock});
  REQUIRE(stage.ok());
  REQUIRE((*stage)->start().ok());
  CapturedFrame frame;
  int wrong = 0, trusted = 0;
  for (int i = 0; i < 200; ++i) {
    if (i % 40 == 20) clock.sleep_until(clock.now() + 400ms + i % 3 * 17ms);
    REQUIRE((*stage)->next(frame).ok());
    const FrameFacts& facts = frame.raw.facts;
    const auto truth = SimBench(camera).true_exposure(facts.sequence);
    REQUIRE(truth.has_value());
    if (!frame.proof.trusted()) continue;
    ++trusted;
    wrong += std::abs(facts.exposure_s - to_seconds(truth->exposure)) > 1e-9;
  }
  CHECK((*stage)->counters().lost_by_camera > 20);
  CHECK((*stage)->counters().relocks == 0);
  CHECK(wrong == 0);
  CHECK(trusted >= 170);
}

TEST_CASE("a change of cycle is followed without a wrong proof", "[capture]") {
  constexpr Exposure kBrighter[] = {{2ms, 1}, {8ms, 1}, {30ms, 1}};
  MisbehavingCamera sensor({.pan_px = 1}, {});
  auto stage = CaptureStage::open(sensor, nullptr, kThree, Mains::Off, {});
  REQUIRE((*stage)->start().ok());
  CapturedFrame frame;
  Tally tally;
  for (int i = 0; i < 120; ++i) {
    if (i == 60) REQUIRE((*stage)->change_cycle(kBrighter).ok());
    REQUIRE((*stage)->next(frame).ok());
    // Eight capture requests of the old cycle are queued.
    judge(frame, sensor.truth(), i < 68 ? std::span<const Exposure>(kThree) : kBrighter, tally);
  }
  CAPTURE(describe(tally));
  CHECK(tally.proved_wrong == 0);
  CHECK(tally.proved >= 105);
}

TEST_CASE("a camera that is labelled by its pictures alone is labelled again after its cycle became brighter",
          "[capture]") {
  constexpr Exposure kTwice[] = {{2ms, 1}, {8ms, 1}, {32ms, 1}};
  MisbehavingCamera sensor(
      {.kind = SensorKind::Gamma8, .per_request = false, .latency = 2, .gain_latency = 2, .pan_px = 1}, {});
  auto stage = CaptureStage::open(sensor, nullptr, kThree, Mains::Off, {});
  REQUIRE((*stage)->start().ok());
  CapturedFrame frame;
  int unknown = 0;
  Tally after;
  for (int i = 0; i < 200; ++i) {
    if (i == 60) REQUIRE((*stage)->change_cycle(kTwice).ok());
    REQUIRE((*stage)->next(frame).ok());
    unknown += i < 60 && !frame.proof.trusted();
    if (i >= 140) judge(frame, sensor.truth(), kTwice, after);
  }
  CAPTURE(unknown, describe(after));
  CHECK(unknown <= 10);
  CHECK(after.trusted_wrong == 0);
  CHECK(after.plausible >= 55);
}

}  // namespace
}  // namespace hdrcam
