// A sensor that is driven by the trigger line, end to end: pulses, frames, and what the proof says of them.
#include "capture/capture_stage.h"

#include <cmath>
#include <map>

#include "hal/fault/faulty_camera.h"
#include "hal/fault/faulty_trigger_line.h"
#include "hal/sim/sim_bench.h"
#include "hal/sim/simulated_trigger_line.h"
#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};

// A simulated sensor in virtual time. Each frame is asked for by driving one pulse.
struct Rig {
  Rig(TriggerMode mode, std::vector<TriggerFault> faults = {}, const char* scene = "walk?size=48x32&rays=1")
      : camera(value_of(simulation_of(scene)), SimTime(clock), 1,
               {.strobe = &strobe_wire, .trigger = &trigger_wire, .mode = mode}),
        trigger(std::make_unique<FaultyTriggerLine>(std::make_unique<SimulatedTriggerLine>(trigger_wire),
                                                    std::move(faults), clock),
                {.mode = mode, .interval = 33'333'333ns}, clock) {
    stage = value_of(CaptureStage::open(camera, &strobe, kCycle, Mains::Off,
                                        {.strobe = StrobePulse::MarksFrame, .trigger = &trigger}));
    require_done(stage->start());
  }
  // Whether the pulse gave a frame.
  bool pulse() {
    REQUIRE(trigger.drive_next());
    return SimBench(camera).true_exposure(frames).has_value();
  }
  const CapturedFrame& next() {
    while (!pulse()) {
    }
    ++frames;
    require_done(stage->next(frame));
    return frame;
  }
  TrueExposure truth() { return SimBench(camera).true_exposure(frame.raw.facts.sequence).value(); }

  VirtualClock clock;
  SimulatedWire trigger_wire{SimTime(clock)}, strobe_wire{SimTime(clock)};
  SimulatedSyncLine strobe{strobe_wire};
  SimulatedCamera camera;
  Trigger trigger;
  std::unique_ptr<CaptureStage> stage;
  CapturedFrame frame;
  std::uint64_t frames = 0;
};

struct Seen {
  int proved = 0, wrong = 0, late = 0, after_gap = 0, slots_wrong = 0;
};

// Takes frames, and holds each label against what the sensor really did.
Seen watch(Rig& rig, int frames) {
  Seen seen;
  for (int i = 0; i < frames; ++i) {
    const FrameFacts& facts = rig.next().raw.facts;
    const TrueExposure truth = rig.truth();
    const bool trusted = (facts.flags & kFrameExposureUnproved) == 0;
    INFO("frame " << facts.sequence << ": " << facts.exposure_s * 1e3 << " ms, truly "
                  << to_seconds(truth.exposure) * 1e3);
    seen.proved += facts.verdict == Verdict::Proved;
    seen.wrong += trusted && std::abs(facts.exposure_s - to_seconds(truth.exposure)) > 1e-9;
    seen.late += (facts.flags & kFrameTriggerLate) != 0;
    seen.after_gap += (facts.flags & kFrameAfterDrop) != 0;
    if (facts.slot >= 0 && (facts.flags & kFrameTriggerLate) == 0)
      seen.slots_wrong += std::chrono::abs(kCycle[facts.slot].time - truth.exposure) > 10us;
    if (trusted) CHECK(facts.timestamp == truth.begin + truth.exposure / 2);
  }
  rig.trigger.stop();
  rig.stage->settle_trigger();
  return seen;
}

constexpr TriggerMode kModes[] = {TriggerMode::FrameStart, TriggerMode::PulseWidth};

TEST_CASE("a triggered sensor gives a frame for each pulse, proved, with the exposure that it had",
          "[capture]") {
  for (const TriggerMode mode : kModes) {
    Rig rig(mode);
    const Seen seen = watch(rig, 120);
    const CaptureCounters& counters = rig.stage->counters();
    CAPTURE(static_cast<int>(mode), proof_of(counters));
    CHECK(seen.wrong == 0);
    CHECK(seen.slots_wrong == 0);
    CHECK(seen.proved >= 110);
    CHECK(seen.late + seen.after_gap == 0);
    CHECK(counters.trigger.pulses == 120);
    CHECK(counters.trigger.answered >= 119);  // the last one is not settled
    CHECK(counters.trigger.unanswered + counters.trigger.spurious == 0);
    CHECK(counters.lost_by_camera == 0);
  }
}

TEST_CASE("in external trigger mode the pulses expose, whatever was requested", "[capture]") {
  Rig rig(TriggerMode::PulseWidth);
  std::map<Duration, int> exposures;
  for (int i = 0; i < 30; ++i) {
    rig.next();
    ++exposures[rig.truth().exposure];
    CHECK(rig.frame.raw.facts.exposure_source == ExposureSource::Reported);
    CHECK(rig.frame.raw.facts.slot == i % 3);
  }
  CHECK(exposures == std::map<Duration, int>{{1ms, 10}, {4ms, 10}, {16ms, 10}});
}

TEST_CASE("where pulses expose, all exposures keep one gain: no cycle may ask for another", "[capture]") {
  const ExposureLimits pulses = Rig(TriggerMode::PulseWidth).stage->exposure_limits().value(),
                       starts = Rig(TriggerMode::FrameStart).stage->exposure_limits().value();
  CHECK(pulses.least_gain == 1);
  CHECK(pulses.greatest_gain == 1);
  CHECK(starts.greatest_gain > 1);
}

TEST_CASE("a pulse that the sensor does not see is named, and the labels stay right", "[capture]") {
  for (const TriggerMode mode : kModes) {
    Rig rig(mode, {{40, TriggerFaultKind::Unseen}, {61, TriggerFaultKind::Unseen}});
    const Seen seen = watch(rig, 100);
    const CaptureCounters& counters = rig.stage->counters();
    CAPTURE(static_cast<int>(mode), proof_of(counters));
    CHECK(seen.wrong == 0);
    CHECK(seen.slots_wrong == 0);
    CHECK(seen.proved >= 85);
    CHECK(seen.after_gap == 2);
    CHECK(counters.lost_by_camera == 2);
    CHECK(counters.trigger.pulses == 102);
    CHECK(counters.trigger.unanswered == 2);
    CHECK(counters.trigger.missing[0] == 40);
    CHECK(counters.trigger.missing[1] == 61);
    CHECK(counters.trigger.spurious == 0);
  }
}

TEST_CASE("a late pulse is flagged in the facts of its frame, whose label is what it really was",
          "[capture]") {
  for (const auto kind : {TriggerFaultKind::Late, TriggerFaultKind::Long}) {
    Rig rig(TriggerMode::PulseWidth, {{31, kind}, {50, kind}});
    const Seen seen = watch(rig, 90);
    const CaptureCounters& counters = rig.stage->counters();
    CAPTURE(static_cast<int>(kind), proof_of(counters));
    CHECK(seen.late == 2);
    CHECK(counters.trigger.late == 2);
    CHECK(seen.wrong == 0);
    CHECK(seen.slots_wrong == 0);
    CHECK(seen.proved >= 80);
    CHECK(to_seconds(counters.trigger.edge_most) == Approx(3e-3));
  }
}

TEST_CASE("the exposure of a long pulse is its measured width", "[capture]") {
  Rig rig(TriggerMode::PulseWidth, {{31, TriggerFaultKind::Long}});
  for (int i = 0; i < 32; ++i) rig.next();
  CHECK(rig.frame.raw.facts.exposure_s == Approx(7e-3));  // 4 ms, and 3 that the injected fault adds
  CHECK((rig.frame.raw.facts.flags & kFrameTriggerLate) != 0);
  CHECK((rig.next().raw.facts.flags & kFrameTriggerLate) == 0);
}

TEST_CASE("an instant without a pulse is no loss of the camera, but the next frame says that one is missing",
          "[capture]") {
  Rig rig(TriggerMode::PulseWidth);
  for (int i = 0; i < 30; ++i) rig.next();
  rig.clock.sleep_until(rig.clock.now() + 100ms);  // the thread was not scheduled
  const Seen seen = watch(rig, 30);
  CHECK(seen.wrong == 0);
  CHECK(seen.slots_wrong == 0);
  CHECK(seen.after_gap == 1);
  CHECK(rig.stage->counters().lost_by_camera == 0);
  CHECK(rig.stage->counters().trigger.left_out == 3);
}

TEST_CASE("an answer without a pulse is counted", "[capture]") {
  Rig rig(TriggerMode::PulseWidth);
  for (int i = 0; i < 10; ++i) rig.next();
  rig.clock.sleep_until(rig.clock.now() + 2ms);
  rig.strobe_wire.strobe(rig.clock.now(), 100us);
  for (int i = 0; i < 10; ++i) rig.next();
  CHECK(rig.stage->counters().trigger.spurious == 1);
  CHECK(rig.stage->counters().trigger.unanswered == 0);
}

TEST_CASE("frames that are taken too late for their pulses are counted, and no label is wrong", "[capture]") {
  constexpr int kPulses = 150, kFrames = 30;  // eight buffers wait for 1200 pulses, of which 1024 are kept
  Rig rig(TriggerMode::PulseWidth);
  for (int i = 0; i < kFrames; ++i) {
    for (int p = 0; p < kPulses; ++p) (void)rig.pulse();
    require_done(rig.stage->next(rig.frame));
    const FrameFacts& facts = rig.frame.raw.facts;
    if ((facts.flags & kFrameExposureUnproved) == 0)
      CHECK(facts.exposure_s == Approx(to_seconds(rig.truth().exposure)));
  }
  const CaptureCounters& counters = rig.stage->counters();
  CHECK(counters.pulses_forgotten >= 15);
  CHECK_THAT(proof_of(counters),
             Catch::EndsWith(fmt::format("strobe or trigger pulses: {}", counters.pulses_forgotten)));
}

TEST_CASE("a line that goes away ends the run though the sensor goes on by itself, after the frames before",
          "[capture]") {
  Rig rig(TriggerMode::FrameStart, {{6, TriggerFaultKind::Unplug}});
  SimulatedCamera camera(value_of(simulation_of("still?size=32x24")), SimTime(rig.clock), 1);  // on no wire
  auto stage = value_of(CaptureStage::open(camera, nullptr, kCycle, Mains::Off, {.trigger = &rig.trigger}));
  require_done(stage->start());
  CapturedFrame frame;
  int taken = 0;
  for (; taken < 40; ++taken) {
    rig.trigger.drive_next();
    if (const auto next = stage->next(frame); !next) {
      require_error(next, ErrorCode::Unplugged);
      break;
    }
  }
  CHECK(taken > 6);
  CHECK(taken < 20);
}

TEST_CASE("a run after one whose line went away counts the frames before its own failure anew", "[capture]") {
  Rig rig(TriggerMode::FrameStart, {{0, TriggerFaultKind::Unplug}});
  SimulatedCamera camera(value_of(simulation_of("still?size=32x24")), SimTime(rig.clock), 1);  // on no wire
  auto stage = value_of(CaptureStage::open(camera, nullptr, kCycle, Mains::Off, {.trigger = &rig.trigger}));
  CapturedFrame frame;
  const auto frames_of_run = [&] {
    require_done(stage->start());
    CHECK_FALSE(rig.trigger.drive_next());
    int frames = 0;
    while (frames < 40 && stage->next(frame)) ++frames;
    require_done(stage->stop());
    return frames;
  };
  const int first = frames_of_run();
  CHECK(first > 0);
  CHECK(frames_of_run() == first);
}

TEST_CASE("a process that was stopped until its patience was over waits for the pulses that follow",
          "[capture]") {
  Rig rig(TriggerMode::PulseWidth);  // its trigger, and another sensor on its wire
  FaultyCamera camera(std::make_unique<SimulatedCamera>(
                          value_of(simulation_of("still?size=32x24")), SimTime(rig.clock), 1,
                          SimulatedWiring{.trigger = &rig.trigger_wire, .mode = TriggerMode::PulseWidth}),
                      {{5, CameraFaultKind::Timeout}});
  auto stage = value_of(CaptureStage::open(camera, nullptr, kCycle, Mains::Off, {.trigger = &rig.trigger}));
  require_done(stage->start());
  CapturedFrame frame;
  for (std::uint64_t i = 0; i < 10; ++i) {
    REQUIRE(rig.trigger.drive_next());
    require_done(stage->next(frame));
    CHECK(frame.raw.facts.sequence == i);
  }
  CHECK(stage->counters().lost_by_camera == 0);
}

TEST_CASE("a sensor that answers no pulse is an error that names the line", "[capture]") {
  Rig rig(TriggerMode::PulseWidth);  // its trigger, and a sensor on another wire
  SimulatedWire dead{SimTime(rig.clock)};
  SimulatedCamera camera(value_of(simulation_of("still?size=32x24")), SimTime(rig.clock), 1,
                         {.trigger = &dead, .mode = TriggerMode::PulseWidth});
  auto stage = value_of(CaptureStage::open(camera, nullptr, kCycle, Mains::Off, {.trigger = &rig.trigger}));
  require_done(stage->start());
  CHECK(rig.trigger.drive_next());
  CapturedFrame frame;
  const auto none = stage->next(frame);
  require_error(none, ErrorCode::Timeout);
  CHECK_THAT(none.error().message, Catch::Contains("trigger line 'sim'") && Catch::Contains("wiring"));
}

}  // namespace
}  // namespace hdrcam
