// Edges of the strobe line by hand: which pulse a frame has, and how many lie between two frames.
#include "capture/strobe_pulses.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFrame = 40ms, kWidth = 4ms;

// A line with a pulse at the beginning of each frame.
struct Line {
  explicit Line(StrobePulse kind = StrobePulse::SpansExposure,
                TimestampMark mark = TimestampMark::ExposureBegin)
      : pulses(kind, 0ms, mark) {}

  Instant begin(int frame) const { return Instant::from_seconds(3) + frame * kFrame; }
  enum class Lost { None, Rise, Fall };
  void pulse(int frame, Lost lost = Lost::None) {
    if (lost != Lost::Rise) pulses.add({begin(frame), true, edges});
    if (lost != Lost::Fall) pulses.add({begin(frame) + kWidth, false, edges + 1});
    edges += 2;
  }
  std::optional<StrobePulses::Pulse> pulse_at(Instant timestamp) const {
    return pulses.pulse_of(timestamp, kFrame / 4);
  }

  StrobePulses pulses;
  std::uint64_t edges = 0;
};

TEST_CASE("a frame has the strobe pulse that is nearest to its time, within a quarter of a frame",
          "[capture]") {
  Line line;
  for (int i = 0; i < 5; ++i) line.pulse(i);
  for (const Duration off : {-10ms, 0ms, 10ms}) {
    const auto pulse = line.pulse_at(line.begin(2) + off);
    REQUIRE(pulse);
    CHECK(pulse->number == 2);
    CHECK(pulse->rise == line.begin(2));
    CHECK(pulse->width == kWidth);
  }
  CHECK_FALSE(line.pulse_at(line.begin(2) + 11ms));
  CHECK_FALSE(line.pulse_at(line.begin(5)));
}

TEST_CASE("where timestamps mark the end of exposures, a strobe pulse without an end is no frame's",
          "[capture]") {
  Line line(StrobePulse::SpansExposure, TimestampMark::ExposureEnd);
  line.pulse(0), line.pulse(1, Line::Lost::Fall), line.pulse(2);
  CHECK(line.pulse_at(line.begin(0) + kWidth)->number == 0);
  CHECK_FALSE(line.pulse_at(line.begin(1) + kWidth));
  CHECK(line.pulse_at(line.begin(2) + kWidth)->number == 2);
}

TEST_CASE("strobe pulses count the frames between two, unless a frame has none or an edge was lost",
          "[capture]") {
  Line line;
  for (int i = 0; i < 4; ++i) line.pulse(i);
  const auto first = line.pulse_at(line.begin(0)), fourth = line.pulse_at(line.begin(3));
  CHECK(line.pulses.since_last(first) == 0);  // no frame before
  line.pulses.matched(first);
  CHECK(line.pulses.since_last(fourth) == 3);
  CHECK(line.pulses.since_last(std::nullopt) == 0);
  line.pulse(4, Line::Lost::Rise), line.pulse(5);
  CHECK(line.pulses.since_last(line.pulse_at(line.begin(5))) == 0);
  line.pulses.matched(fourth);
  line.pulses.matched(std::nullopt);
  CHECK(line.pulses.since_last(fourth) == 0);
}

TEST_CASE("as many strobe pulses as wait on a line are kept for their frames, and older frames are too late",
          "[capture]") {
  constexpr int kWaiting = SyncLine::kMostWaiting / 2, kLost = 20;
  Line line;
  for (int i = 0; i < kWaiting; ++i) line.pulse(i);
  for (int i = 0; i < kWaiting; ++i) CHECK(line.pulse_at(line.begin(i)));
  CHECK_FALSE(line.pulses.forgot(line.begin(-1)));  // before the first
  for (int i = kWaiting; i < kWaiting + kLost; ++i) line.pulse(i);
  for (int i = 0; i < kWaiting + kLost; ++i) {
    CHECK(line.pulse_at(line.begin(i)).has_value() == (i >= kLost));
    CHECK(line.pulses.forgot(line.begin(i)) == (i < kLost));
  }
}

}  // namespace
}  // namespace hdrcam
