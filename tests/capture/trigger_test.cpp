// Trigger pulses: when they are due, what is late, what a sensor answers.
#include "capture/trigger.h"

#include <thread>

#include "capture/edge_errors.h"
#include "capture/trigger_ledger.h"
#include "capture/trigger_thread.h"
#include "hal/fault/faulty_trigger_line.h"
#include "hal/sim/simulated_trigger_line.h"
#include "tests/allocation_checks.h"
#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using namespace std::chrono_literals;
using Catch::Contains;

constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};

ExposureSchedule schedule_of(std::span<const Exposure> cycle) {
  return value_of(ExposureSchedule::observed(cycle));
}

TriggerOptions options_of(TriggerMode mode, Duration interval = 20ms) {
  return {.mode = mode, .interval = interval};
}

DrivenEdge at(Instant instant) { return {instant, 0us}; }

// As planned, but so much later.
TriggerPulse driven(PulseTrain& train, const PlannedPulse& planned, Duration late = 0us,
                    Duration longer = 0us) {
  const Instant rise = planned.begin + late;
  return train.driven(planned, at(rise), at(rise + planned.width + longer));
}

TEST_CASE("pulses come on a grid that does not drift, as wide as the exposures in turn") {
  PulseTrain train(options_of(TriggerMode::PulseWidth), schedule_of(kCycle));
  const Instant first = Instant::from_seconds(5);
  train.start(first);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const PlannedPulse planned = train.next(first + 20ms * static_cast<int>(i) + -1ms);
    REQUIRE(planned.number == i);
    REQUIRE(planned.begin == first + 20ms * static_cast<int>(i));
    REQUIRE(planned.width == kCycle[i % 3].time);
    const TriggerPulse pulse = driven(train, planned, 100us);
    REQUIRE(pulse.index == i);
    REQUIRE_FALSE(pulse.late);
  }
}

TEST_CASE("pulses that only start frames all have the width that was asked for") {
  PulseTrain train(options_of(TriggerMode::FrameStart), schedule_of(kCycle));
  train.start(Instant::from_seconds(5));
  for (int i = 0; i < 4; ++i) CHECK(train.next(Instant::from_seconds(1)).width == 200us);
}

TEST_CASE("a pulse with an edge beyond the tolerance is late, whichever edge it is") {
  PulseTrain train(options_of(TriggerMode::PulseWidth), schedule_of(kCycle));
  train.start(Instant::from_seconds(5));
  const Instant before = Instant::from_seconds(5);
  CHECK_FALSE(driven(train, train.next(before), 500us, 500us).late);
  CHECK(driven(train, train.next(before), 501us).late);
  const TriggerPulse longer = driven(train, train.next(before), 0us, 501us);
  CHECK(longer.late);
  CHECK(longer.width() == 16ms + 501us);
  CHECK(longer.begin_error() == 0us);
  CHECK(longer.width_error() == 501us);
}

TEST_CASE("a pulse that would meet the next one is left out, and the slots go on as if it had come") {
  PulseTrain train(options_of(TriggerMode::PulseWidth), schedule_of(kCycle));
  const Instant first = Instant::from_seconds(5);
  train.start(first);
  (void)driven(train, train.next(first));
  (void)driven(train, train.next(first + 20ms));
  // 16 ms and a gap of 1 ms fit an interval of 20 ms until 3 ms after it began
  const PlannedPulse in_time = train.next(first + 43ms);
  CHECK(in_time.number == 2);
  CHECK(driven(train, in_time, 3ms).late);
  const PlannedPulse after = train.next(first + 60ms + 80ms);  // asleep until the 7th is due
  CHECK(after.number == 7);
  CHECK(after.slot == 1);
  const TriggerPulse pulse = driven(train, after);
  CHECK(pulse.index == 3);
}

TEST_CASE("after a pulse that ended late, the next one waits for the gap") {
  PulseTrain train(options_of(TriggerMode::PulseWidth), schedule_of(kCycle));
  const Instant first = Instant::from_seconds(5);
  train.start(first);
  (void)driven(train, train.next(first), 0us, 19ms + 500us);  // until 0.5 ms after the next was due
  const PlannedPulse next = train.next(first + 20ms + 500us);
  CHECK(next.number == 1);
  CHECK(next.not_before == first + 20ms + 500us + 1ms);
}

TEST_CASE("of the widest pulses none is left out, as late as their edges may be") {
  const TriggerOptions options = options_of(TriggerMode::PulseWidth);
  const Duration widest = PulseTrain::longest_width(options);
  const Exposure cycle[] = {{1ms, 1}, {widest - 1us, 1}, {widest, 1}};  // two in a row
  const ExposureSchedule schedule = schedule_of(cycle);
  REQUIRE(PulseTrain::check(options, schedule).ok());
  for (const Duration late : {0us, 50us, 500us}) {
    PulseTrain train(options, schedule);
    const Instant first = Instant::from_seconds(5);
    train.start(first);
    Instant now = first;
    for (std::uint64_t i = 0; i < 100; ++i) {
      const PlannedPulse planned = train.next(now);
      REQUIRE(planned.number == i);
      now = std::max(planned.not_before, planned.begin) + late + planned.width;
      (void)train.driven(planned, at(planned.begin + late), at(now));
    }
  }
}

TEST_CASE("pulses that cannot be are refused with what to change") {
  const ExposureSchedule schedule = schedule_of(kCycle);
  const auto longer = PulseTrain::check(options_of(TriggerMode::PulseWidth, 16ms), schedule);
  require_error(longer, ErrorCode::BadExposure);
  CHECK_THAT(longer.error().message, Contains("pulse of 16 ms") && Contains("frame of 16 ms") &&
                                         Contains("gap of 1 ms") && Contains("500 us late") &&
                                         Contains("14.5 ms") && Contains("--shutter"));
  CHECK(PulseTrain::check(options_of(TriggerMode::PulseWidth, 17500us), schedule).ok());
  // what the camera's room allows to the nanosecond, though a message names fewer digits
  const Exposure whole[] = {{1ms, 1}, {31'833'333ns, 1}};
  CHECK(PulseTrain::check(options_of(TriggerMode::PulseWidth, 33'333'333ns), schedule_of(whole)).ok());
  // .. and what rounding to the sensor's step makes of the longest still fits
  const TriggerOptions fast = options_of(TriggerMode::PulseWidth, 16'666'667ns);
  CHECK(PulseTrain::longest_width(fast, 100us) == 15100us);
  const Exposure rounded_up[] = {{1ms, 1}, {15200us, 1}};
  const auto beyond = PulseTrain::check(fast, schedule_of(rounded_up), 100us);
  require_error(beyond, ErrorCode::BadExposure);
  CHECK_THAT(beyond.error().message, Contains("shorten it to 15.1 ms"));
  TriggerOptions wide = options_of(TriggerMode::FrameStart);
  wide.width = 19500us;
  const auto wider = PulseTrain::check(wide, schedule);
  require_error(wider, ErrorCode::BadExposure);
  CHECK_THAT(wider.error().message, Contains("--trigger-width"));
  TriggerOptions apart = options_of(TriggerMode::FrameStart);
  apart.gap = 100ms;
  const auto gap = PulseTrain::check(apart, schedule);
  require_error(gap, ErrorCode::BadExposure);
  CHECK(
      gap.error().message ==
      "a gap of 100 ms between trigger pulses and edges up to 500 us late do not fit a frame of 20 ms; lower "
      "--trigger-gap, --trigger-tolerance or --framerate");
  const Exposure gains[] = {{1ms, 1}, {4ms, 2}};
  const auto differ = PulseTrain::check(options_of(TriggerMode::PulseWidth), schedule_of(gains));
  require_error(differ, ErrorCode::Invalid);
  CHECK_THAT(differ.error().message, Contains("gains 1 and 2") && Contains("--gain"));
  CHECK(PulseTrain::check(options_of(TriggerMode::FrameStart), schedule_of(gains)).ok());
}

// A trigger in virtual time, and the other end of its wire.
struct Driven {
  explicit Driven(TriggerMode mode, std::vector<TriggerFault> faults = {})
      : trigger(std::make_unique<FaultyTriggerLine>(std::make_unique<SimulatedTriggerLine>(wire),
                                                    std::move(faults), clock),
                options_of(mode), clock) {
    require_done(trigger.start(schedule_of(kCycle)));
  }
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  SimulatedSyncLine seen{wire};
  Trigger trigger;
};

TEST_CASE("every pulse that is driven is seen on the wire, at the instants that were reported") {
  Driven driven(TriggerMode::PulseWidth);
  std::uint64_t in_pulses = 0;
  for (int i = 0; i < 60; ++i) {
    const std::uint64_t before = allocations_so_far();
    const bool drove = driven.trigger.drive_next();
    const auto pulse = driven.trigger.take();
    in_pulses += allocations_so_far() - before;
    REQUIRE(drove);
    REQUIRE(pulse);
    REQUIRE(pulse->planned.number == static_cast<std::uint64_t>(i));
    REQUIRE(pulse->width() == kCycle[i % 3].time);
    REQUIRE_FALSE(pulse->late);
    REQUIRE(value_of(driven.seen.wait_edge(0us)).at == pulse->rise.at);
    REQUIRE(value_of(driven.seen.wait_edge(0us)).at == pulse->fall.at);
  }
  CHECK_ALLOCATIONS(in_pulses == 0);
  CHECK_FALSE(driven.wire.level());
  CHECK(driven.trigger.driven() == 60);
}

TEST_CASE("a line that goes away ends the pulses, and says why") {
  Driven driven(TriggerMode::PulseWidth, {{2, TriggerFaultKind::Unplug}});
  CHECK(driven.trigger.drive_next());
  CHECK(driven.trigger.drive_next());
  CHECK_FALSE(driven.trigger.failure());
  CHECK_FALSE(driven.trigger.drive_next());
  CHECK_FALSE(driven.trigger.drive_next());
  REQUIRE(driven.trigger.failure());
  CHECK(driven.trigger.failure()->code == ErrorCode::Unplugged);
}

TEST_CASE("a schedule that follows another is driven from the next pulse on") {
  Driven driven(TriggerMode::PulseWidth);
  CHECK(driven.trigger.drive_next());
  const Exposure shorter[] = {{2ms, 1}, {2500us, 1}, {3ms, 1}};
  require_done(driven.trigger.follow(schedule_of(shorter)));
  CHECK(driven.trigger.drive_next());
  (void)driven.trigger.take();
  CHECK(driven.trigger.take()->width() == 2500us);
  const Exposure too_long[] = {{20ms, 1}};
  require_error(driven.trigger.follow(schedule_of(too_long)), ErrorCode::BadExposure);
}

TEST_CASE(
    "in real time the thread drives every pulse in order, and leaves the line inactive when it is stopped") {
  SimulatedWire wire{SimTime()};
  SimulatedSyncLine seen(wire);
  Trigger trigger(std::make_unique<SimulatedTriggerLine>(wire), options_of(TriggerMode::PulseWidth),
                  posix_clock());
  const TriggerThread thread(trigger);
  if (!thread.realtime()) CHECK_THAT(thread.realtime().error().message, Contains("ulimit -r 50"));
  for (int run = 0; run < 2; ++run) {
    require_done(trigger.start(schedule_of(kCycle)));
    std::vector<TriggerPulse> pulses;
    for (int i = 0; i < 2000 && pulses.size() < 12; ++i) {
      while (const auto pulse = trigger.take()) pulses.push_back(*pulse);
      std::this_thread::sleep_for(2ms);
    }
    trigger.stop();
    CHECK_FALSE(wire.level());
    while (const auto pulse = trigger.take()) pulses.push_back(*pulse);
    REQUIRE(pulses.size() >= 12);
    CHECK(pulses.size() == trigger.driven());
    for (const TriggerPulse& pulse : pulses) {
      const Edge rise = value_of(seen.wait_edge(0us)), fall = value_of(seen.wait_edge(0us));
      CHECK(rise.at == pulse.rise.at);
      CHECK(fall.at == pulse.fall.at);
      // however busy the machine, a pulse is never early and never too short, and where it is not late, it is
      // right
      CHECK(pulse.begin_error() >= 0us);
      CHECK(pulse.width_error() >= 0us);
      CHECK(pulse.late == (pulse.begin_error() > 500us || pulse.width_error() > 500us));
    }
    require_error(seen.wait_edge(0us), ErrorCode::Timeout);
  }
}

// A ledger that is told of pulses at 10 ms intervals, each answered 100 us later unless it is said otherwise.
struct Answered {
  Answered() { ledger.start({.mode = TriggerMode::FrameStart, .interval = 10ms}); }
  Instant begin(int i) const { return Instant::from_seconds(3) + 10ms * i; }
  void pulse(int i, bool late = false) {
    TriggerPulse pulse;
    pulse.planned.number = static_cast<std::uint64_t>(i);
    pulse.planned.begin = begin(i), pulse.planned.width = 200us;
    pulse.rise.at = begin(i), pulse.fall.at = begin(i) + 200us, pulse.late = late;
    ledger.pulse(pulse);
  }
  void answer(Instant when) { ledger.answer({when, true, 0}), ledger.answer({when + 1ms, false, 0}); }
  TriggerLedger ledger;
};

TEST_CASE("each pulse's answer is found, and what is missing or not asked for is counted and named") {
  Answered line;
  for (int i = 0; i < 200; ++i) {
    if (i == 50 || i == 51) continue;  // not driven
    line.pulse(i, i == 9);
    if (i == 30) line.answer(line.begin(29) + 7ms);  // nobody asked
    if (i != 17 && i != 120) line.answer(line.begin(i) + 100us);
    if (i % 4 == 0) line.ledger.settle(line.begin(i) + -5ms);
  }
  line.ledger.settle(line.begin(210));
  const TriggerCounters& counters = line.ledger.counters();
  CHECK(counters.pulses == 198);
  CHECK(counters.late == 1);
  CHECK(counters.left_out == 2);
  CHECK(counters.answered == 196);
  CHECK(counters.unanswered == 2);
  CHECK(counters.missing[0] == 17);
  CHECK(counters.missing[1] == 120);
  CHECK(counters.spurious == 1);
  CHECK(counters.spurious_at[0] == line.begin(29) + 7ms);
  const std::string text = sentence_of(counters, "FSYNC", {.mode = TriggerMode::FrameStart}, true);
  CHECK_THAT(text,
             Contains("trigger 'FSYNC' (frame start): 198 pulses, 1 late (more than 500 us), 2 left out") &&
                 Contains("196 answered, 2 not (pulse 17, 120), 1 answers without a pulse"));
  CHECK_THAT(sentence_of(counters, "FSYNC", {}, false), !Contains("answered"));
}

TEST_CASE("an answer may be stamped a little before the pulse that asked for it") {
  Answered line;
  line.pulse(0);
  line.answer(line.begin(0) + -200us);
  line.ledger.settle(line.begin(2));
  CHECK(line.ledger.counters().answered == 1);
  CHECK(line.ledger.counters().spurious == 0);
}

TEST_CASE("pulses are answered although the edges come later than all of them") {
  Answered line;
  for (int i = 0; i < 1000; ++i) line.pulse(i);
  for (int i = 0; i < 1000; ++i) line.answer(line.begin(i) + 100us);
  line.ledger.settle(line.begin(1010));
  CHECK(line.ledger.counters().answered == 1000);
  CHECK(line.ledger.counters().unanswered + line.ledger.counters().spurious == 0);
}

TEST_CASE("however many pulses or answers wait, each is counted once, in order of time") {
  constexpr int kMany = 5000;
  Answered silent;
  silent.answer(silent.begin(0) + -7ms);  // nobody asked
  for (int i = 0; i < kMany; ++i) silent.pulse(i);
  silent.ledger.settle(silent.begin(kMany + 10));
  CHECK(silent.ledger.counters().answered == 0);
  CHECK(silent.ledger.counters().unanswered == kMany);
  CHECK(silent.ledger.counters().missing == std::array<std::uint64_t, 3>{0, 1, 2});
  CHECK(silent.ledger.counters().spurious == 1);

  Answered noisy;
  noisy.pulse(0);
  for (int i = 10; i < kMany + 10; ++i) noisy.answer(noisy.begin(i));
  noisy.ledger.settle(noisy.begin(kMany + 20));
  CHECK(noisy.ledger.counters().answered == 0);
  CHECK(noisy.ledger.counters().unanswered == 1);
  CHECK(noisy.ledger.counters().spurious == kMany);
  CHECK(noisy.ledger.counters().spurious_at[0] == noisy.begin(10));
}

TEST_CASE("the errors of edges are summed up as mean, 99th percentile and the worst") {
  EdgeErrors errors;
  for (int i = 1; i <= 1000; ++i) errors.add(std::chrono::microseconds(i % 2 == 0 ? i : -i));
  CHECK(errors.count() == 1000);
  CHECK(to_seconds(errors.mean()) == Approx(500.5e-6));
  CHECK(errors.p99() >= 990us);
  CHECK(errors.p99() <= 1000us);
  CHECK(errors.most() == 1000us);
  EdgeErrors outlier;
  for (int i = 0; i < 999; ++i) outlier.add(10us);
  outlier.add(50ms);
  CHECK(outlier.p99() >= 10us);
  CHECK(outlier.p99() <= 12us);
  CHECK(outlier.most() == 50ms);
}

}  // namespace
}  // namespace hdrcam
