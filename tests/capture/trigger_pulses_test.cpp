// Driven pulses by hand: which of them began a frame, and how many lie between two frames.
#include "capture/trigger_pulses.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kInterval = 40ms;
constexpr Duration kWidths[] = {1ms, 4ms, 16ms};

Instant begin(int number) { return Instant::from_seconds(3) + number * kInterval; }
Instant end(int number) { return begin(number) + kWidths[number % 3]; }

// The pulse of that interval; `index`: those driven before it.
TriggerPulse pulse(int number, int index) {
  TriggerPulse pulse;
  pulse.planned.number = static_cast<std::uint64_t>(number);
  pulse.index = static_cast<std::uint64_t>(index);
  pulse.rise.at = begin(number), pulse.fall.at = end(number);
  return pulse;
}

// -1: no pulse.
int number_of(const std::optional<TriggerPulse>& pulse) {
  return pulse ? static_cast<int>(pulse->planned.number) : -1;
}

TriggerPulses six(TriggerMode mode, TimestampMark mark) {
  TriggerPulses pulses(mode, mark, kInterval);
  for (int i = 0; i < 6; ++i) pulses.add(pulse(i, i));
  return pulses;
}

TEST_CASE("a frame's trigger pulse is found by the edge that its timestamp marks", "[capture]") {
  for (const TriggerMode mode : {TriggerMode::FrameStart, TriggerMode::PulseWidth}) {
    const TriggerPulses by_begin = six(mode, TimestampMark::ExposureBegin);
    for (int i = 0; i < 6; ++i) CHECK(number_of(by_begin.pulse_of(begin(i) + 9ms)) == i);
    CHECK_FALSE(by_begin.pulse_of(begin(3) + 11ms));
  }
  const TriggerPulses by_end = six(TriggerMode::PulseWidth, TimestampMark::ExposureEnd);
  for (int i = 0; i < 6; ++i) CHECK(number_of(by_end.pulse_of(end(i) + 9ms)) == i);
}

TEST_CASE("where controls set the exposure whose end is stamped, the frame's trigger pulse is the one before",
          "[capture]") {
  const TriggerPulses pulses = six(TriggerMode::FrameStart, TimestampMark::ExposureEnd);
  for (int i = 0; i < 6; ++i)
    for (const Duration exposure : {0ms, 20ms, 39ms})
      CHECK(number_of(pulses.pulse_of(begin(i) + exposure)) == i);
  CHECK_FALSE(pulses.pulse_of(begin(0) + -1ms));
}

TEST_CASE("trigger pulses between two frames are counted, and instants without one apart", "[capture]") {
  TriggerPulses pulses(TriggerMode::FrameStart, TimestampMark::ExposureBegin, kInterval);
  pulses.add(pulse(0, 0)), pulses.add(pulse(1, 1)), pulses.add(pulse(4, 2));  // 2 and 3 were left out
  const auto first = pulses.pulse_of(begin(0)), last = pulses.pulse_of(begin(4));
  CHECK(pulses.since_last(first) == 0);  // no frame before
  CHECK(pulses.left_out_since_last(first) == 0);
  pulses.matched(first);
  CHECK(pulses.since_last(last) == 2);
  CHECK(pulses.left_out_since_last(last) == 2);
  pulses.matched(last);  // and a stamp that steps back
  CHECK(pulses.since_last(first) == 0);
  CHECK(pulses.left_out_since_last(first) == 0);
  pulses.matched(std::nullopt);
  CHECK(pulses.since_last(last) == 0);
  CHECK(pulses.left_out_since_last(last) == 0);
}

TEST_CASE("as many trigger pulses as wait are kept for their frames, and older frames are too late",
          "[capture]") {
  constexpr int kWaiting = static_cast<int>(kMostWaitingPulses), kLost = 20;
  TriggerPulses pulses(TriggerMode::PulseWidth, TimestampMark::ExposureBegin, kInterval);
  for (int i = 0; i < kWaiting; ++i) pulses.add(pulse(i, i));
  for (int i = 0; i < kWaiting; ++i) CHECK(number_of(pulses.pulse_of(begin(i))) == i);
  CHECK_FALSE(pulses.forgot(begin(-1)));  // before the first
  for (int i = kWaiting; i < kWaiting + kLost; ++i) pulses.add(pulse(i, i));
  for (int i = 0; i < kWaiting + kLost; ++i) {
    CHECK(number_of(pulses.pulse_of(begin(i))) == (i < kLost ? -1 : i));
    CHECK(pulses.forgot(begin(i)) == (i < kLost));
  }
}

}  // namespace
}  // namespace hdrcam
