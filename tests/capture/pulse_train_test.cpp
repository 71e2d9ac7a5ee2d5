// When trigger pulses are due, and what is late.
#include "capture/pulse_train.h"

#include "tests/capture/trigger_cycle.h"

namespace hdrcam {
namespace {

using namespace std::chrono_literals;
using Catch::Contains;
using test::options_of;
using test::schedule_of;

DrivenEdge at(Instant instant) { return {instant, 0us}; }

// As planned, but so much later.
TriggerPulse driven(PulseTrain& train, const PlannedPulse& planned, Duration late = 0us,
                    Duration longer = 0us) {
  const Instant rise = planned.begin + late;
  return train.driven(planned, at(rise), at(rise + planned.width + longer));
}

TEST_CASE("pulses come on a grid that does not drift, as wide as the exposures in turn") {
  PulseTrain train(options_of(TriggerMode::PulseWidth), schedule_of(test::kTriggerCycle));
  const Instant first = Instant::from_seconds(5);
  train.start(first);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const PlannedPulse planned = train.next(first + 20ms * static_cast<int>(i) + -1ms);
    REQUIRE(planned.number == i);
    REQUIRE(planned.begin == first + 20ms * static_cast<int>(i));
    REQUIRE(planned.width == test::kTriggerCycle[i % 3].time);
    const TriggerPulse pulse = driven(train, planned, 100us);
    REQUIRE(pulse.index == i);
    REQUIRE_FALSE(pulse.late);
  }
}

TEST_CASE("pulses that only start frames all have the width that was asked for") {
  PulseTrain train(options_of(TriggerMode::FrameStart), schedule_of(test::kTriggerCycle));
  train.start(Instant::from_seconds(5));
  for (int i = 0; i < 4; ++i) CHECK(train.next(Instant::from_seconds(1)).width == 200us);
}

TEST_CASE("a pulse with an edge beyond the tolerance is late, whichever edge it is") {
  PulseTrain train(options_of(TriggerMode::PulseWidth), schedule_of(test::kTriggerCycle));
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
  PulseTrain train(options_of(TriggerMode::PulseWidth), schedule_of(test::kTriggerCycle));
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
  PulseTrain train(options_of(TriggerMode::PulseWidth), schedule_of(test::kTriggerCycle));
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

TEST_CASE("the widest pulse is one of the times that the sensor has, which begin at its shortest") {
  const TriggerOptions options = options_of(TriggerMode::PulseWidth, 16'666'667ns);
  const Duration widest = PulseTrain::longest_width(options);  // 15.17 ms
  for (const Duration shortest : {100us, 160us, 170us}) {
    CameraCapabilities camera;
    camera.exposure_min = shortest, camera.exposure_max = 1s, camera.exposure_step = 100us;
    const Duration longest = longest_within(widest, camera);
    CAPTURE(shortest.count(), longest.count());
    CHECK(value_of(quantised({longest, 1}, camera)).time == longest);
    const Exposure fits[] = {{1ms, 1}, {longest, 1}}, beyond[] = {{1ms, 1}, {longest + 100us, 1}};
    CHECK(PulseTrain::check(options, schedule_of(fits), camera).ok());
    CHECK_FALSE(PulseTrain::check(options, schedule_of(beyond), camera).ok());
  }
}

TEST_CASE("pulses that cannot be are refused with what to change") {
  const ExposureSchedule schedule = schedule_of(test::kTriggerCycle);
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
  CameraCapabilities camera;
  camera.exposure_min = 100us, camera.exposure_step = 100us;
  const Exposure rounded_up[] = {{1ms, 1}, {15200us, 1}};
  const auto beyond = PulseTrain::check(fast, schedule_of(rounded_up), camera);
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

}  // namespace
}  // namespace hdrcam
