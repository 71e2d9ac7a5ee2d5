// Buffers, numbers, times and pulses by hand: which frames were lost, and what the matcher says of each
// frame.
#include "capture/frame_matcher.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kAgreed{33'333'333};
constexpr Exposure kThree[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};

Duration part_of(Duration frame, double frames) {
  return Duration(static_cast<Duration::rep>(static_cast<double>(frame.count()) * frames));
}

// A camera that completes one request a frame, and the matcher of its buffers.
class Stream {
 public:
  explicit Stream(const FrameMatcherOptions& options, std::span<const Exposure> cycle = kThree,
                  Duration kept = kAgreed)
      : schedule_(ExposureSchedule::observed(cycle).value()),
        options_(options),
        kept_(kept),
        matcher_(options, schedule_) {
    buffer_.sequence = 1000;
    buffer_.timestamp = Instant::from_seconds(50);
    for (int i = 0; i < 8; ++i) requests_.push_back(matcher_.next_request());
  }

  FrameMatcher& matcher() { return matcher_; }
  // The buffer of the next request, `numbers` and `frames` after the one before.
  CapturedBuffer& next(std::int64_t numbers = 1, double frames = 1) {
    requests_.push_back(matcher_.next_request());
    buffer_.cookie = cookie_++;
    buffer_.sequence = static_cast<std::uint64_t>(static_cast<std::int64_t>(buffer_.sequence) + numbers);
    buffer_.timestamp = buffer_.timestamp + part_of(kept_, frames);
    buffer_.control_late = false;
    return buffer_;
  }
  MatchedFrame match() { return matcher_.match(buffer_); }
  MatchedFrame step(std::int64_t numbers = 1, double frames = 1) {
    next(numbers, frames);
    return match();
  }
  // A pulse of the strobe line that many frames after the last buffer, and which of its edges is not seen.
  enum class Lost { Neither, Rise, Fall };
  void pulse(double frames, Lost lost = Lost::Neither) {
    const Instant rise = buffer_.timestamp + part_of(kept_, frames) + options_.strobe_after_timestamp;
    edges_of(rise, 4ms, lost);
  }
  void edges_of(Instant rise, Duration width, Lost lost = Lost::Neither) {
    if (lost != Lost::Rise) matcher_.strobe({rise, true, edges_});
    if (lost != Lost::Fall) matcher_.strobe({rise + width, false, edges_ + 1});
    edges_ += 2;
  }
  // What the schedule wants of that request, ln E.
  double wanted(std::int64_t cookie) const {
    return log_product(schedule_.exposure_of(static_cast<std::uint64_t>(cookie)));
  }
  const std::vector<ExposureRequest>& requests() const { return requests_; }

 private:
  ExposureSchedule schedule_;
  FrameMatcherOptions options_;
  Duration kept_;
  FrameMatcher matcher_;
  std::vector<ExposureRequest> requests_;
  std::uint64_t cookie_ = 0, edges_ = 0;
  CapturedBuffer buffer_;
};

FrameMatcherOptions with_delays(int exposure, int gain) {
  return {.frame_duration = kAgreed, .delays = ControlDelays{exposure, gain}};
}

struct Gap {
  const char* name;
  std::int64_t numbers;  // by which the driver's counter goes on
  double frames;         // by which its time goes on
  int pulses;            // of the strobe line; -1: there is no line, -2: an edge was lost
  int want;              // frames
};

constexpr Gap kGaps[] = {
    {"all agree on the next frame", 1, 1, 1, 1},
    {"all agree on three", 3, 3, 3, 3},
    {"number and time agree", 4, 4, -1, 4},
    {"the counter hides drops", 1, 3, -1, 3},
    {"the counter hides drops, the strobe sees them", 1, 3, 3, 3},
    {"the counter jumps", 5, 1, -1, 1},
    {"the counter jumps, and the strobe says so", 5, 2, 2, 2},
    {"the counter restarts", -900, 2, -1, 2},
    {"the counter restarts at a time between two frames", -900, 1.5, -1, 1},
    {"the time is between two frames", 3, 2.5, -1, 3},
    {"the time jitters by a quarter of a frame", 1, 2.25, -1, 2},
    {"the counter hides the loss of 249", 1, 250, -1, 250},
    {"the clock is set an hour ahead", 1, 108'000, -1, 1},
    {"the clock is set ahead, and two frames are lost", 3, 108'000, -1, 3},
    {"the counter restarts after an hour of sleep", -900, 108'000, -1, 1},
    {"a long gap that number and time agree on", 108'000, 108'000, -1, 108'000},
    {"the time stands still", 2, 0, -1, 2},
    {"the time goes back", 2, -3, -1, 2},
    {"the time misses drops, number and strobe see them", 3, 1, 3, 3},
    {"the time misses drops, and an edge was lost", 3, 1, -2, 1},
    {"all three disagree: the time is on the grid", 1, 2, 4, 2},
    {"all three disagree: the time is between two frames", 3, 1.4, 2, 3},
};

TEST_CASE("number, time and strobe: two that agree say how many frames were lost", "[capture]") {
  for (const Duration kept : {kAgreed, Duration(40ms), Duration(28ms), Duration(66ms), Duration(100ms)}) {
    for (const Gap& gap : kGaps) {
      CAPTURE(to_seconds(kept), gap.name);
      FrameMatcherOptions options{.frame_duration = kAgreed};
      if (gap.pulses != -1) options.strobe = StrobePulse::MarksFrame;
      Stream stream(options, kThree, kept);
      std::uint64_t index = 0;
      for (int i = 0; i < 12; ++i) {
        stream.pulse(1);
        const MatchedFrame frame = stream.step();
        CHECK(frame.index == static_cast<std::uint64_t>(i));
        CHECK(frame.lost_before == 0);
        index = frame.index;
      }
      const int pulses = gap.pulses == -2 ? 3 : std::max(0, gap.pulses);
      for (int i = 1; i <= pulses; ++i) {
        const bool lost = gap.pulses == -2 && i == 2;
        stream.pulse(gap.frames * i / pulses, lost ? Stream::Lost::Fall : Stream::Lost::Neither);
      }
      const MatchedFrame after = stream.step(gap.numbers, gap.frames);
      CHECK(after.lost_before == gap.want - 1);
      CHECK(after.index == index + static_cast<std::uint64_t>(gap.want));
      stream.pulse(1);
      CHECK(stream.step().lost_before == 0);
    }
  }
}

TEST_CASE("a frame whose time is in the past makes no gap before the one after it", "[capture]") {
  Stream stream({.frame_duration = kAgreed});
  for (int i = 0; i < 12; ++i) stream.step();
  CHECK(stream.step(1, -29).lost_before == 0);
  CHECK(stream.step(1, 31).lost_before == 0);
  CHECK(stream.step(1, 3).lost_before == 2);
}

TEST_CASE("a camera that becomes slower is known after half of the intervals that count", "[capture]") {
  Stream stream({.frame_duration = kAgreed});
  for (int i = 0; i < 20; ++i) stream.step();
  int lost = 0;
  for (int i = 0; i < 20; ++i) {
    const MatchedFrame frame = stream.step(1, 2);
    lost += frame.lost_before;
    if (i >= 4) CHECK(frame.lost_before == 0);
  }
  CHECK(lost == 4);  // until then a frame that comes late is one that was lost
  CHECK(stream.step(1, 4).lost_before == 1);
}

TEST_CASE("a camera of which every second frame is lost is no slow camera", "[capture]") {
  Stream stream({.frame_duration = kAgreed}, kThree, 40ms);
  for (int i = 0; i < 30; ++i) CHECK(stream.step(2, 2).lost_before == (i == 0 ? 0 : 1));
}

TEST_CASE("the exposure of a frame is that of the request as many frames before as its control takes",
          "[capture]") {
  for (int delay = 0; delay <= 3; ++delay) {
    Stream stream(with_delays(delay, delay));
    for (int i = 0; i < 30; ++i) {
      const MatchedFrame frame = stream.step();
      CAPTURE(delay, i);
      REQUIRE(frame.evidence.claims.size() == (i >= delay ? 1u : 0u));
      if (i < delay) continue;
      const ExposureClaim& claim = frame.evidence.claims[0];
      CHECK(claim.log_value() == Approx(stream.wanted(i - delay)));
      CHECK(claim.source == ExposureSource::Predicted);
      CHECK_FALSE(frame.evidence.prediction_doubtful);
      CHECK(stream.matcher().slot_of(claim) == (i - delay) % 3);
    }
  }
}

TEST_CASE("a request stays due while frames are lost", "[capture]") {
  constexpr int kDelay = 2;
  Stream stream(with_delays(kDelay, kDelay));
  for (int i = 0; i < 9; ++i) stream.step();  // request 8 was due when frame 8 began
  REQUIRE(stream.step(3, 3).index == 11);     // request 9 when 9, 10 and 11 did
  // Frame 12 begins with request 10, 13 with 11.
  const std::int64_t shown[] = {9, 9, 10, 11, 12};
  for (const std::int64_t cookie : shown)
    CHECK(stream.step().evidence.claims[0].log_value() == Approx(stream.wanted(cookie)));
}

TEST_CASE("a request that was queued after frames were lost did not act on them", "[capture]") {
  constexpr int kDelay = 2;
  for (const bool held_up : {true, false}) {
    Stream stream(with_delays(kDelay, kDelay));
    for (int i = 0; i < 9; ++i) stream.step();  // request 8 was due when frame 8 began
    const CapturedBuffer& after = stream.next(20, 20);
    const ExposureRequest& its = stream.requests()[9];
    // Just before its frame, or long before those that were lost.
    stream.matcher().queued(its, after.timestamp + -part_of(kAgreed, held_up ? 0.5 : 27.5));
    CAPTURE(held_up);
    const MatchedFrame frame = stream.match();
    CHECK(frame.index == 28);
    CHECK(frame.evidence.claims[0].log_value() == Approx(stream.wanted(held_up ? 8 : 9)));
    const std::int64_t shown[] = {held_up ? 8 : 9, 9, 10, 11};
    for (const std::int64_t cookie : shown)
      CHECK(stream.step().evidence.claims[0].log_value() == Approx(stream.wanted(cookie)));
  }
}

TEST_CASE("of two controls the faster is held back, so that one frame shows both", "[capture]") {
  constexpr Exposure kGains[] = {{1ms, 1}, {4ms, 2}, {16ms, 8}};
  for (const ControlDelays delays : {ControlDelays{2, 1}, ControlDelays{1, 3}, ControlDelays{0, 2}}) {
    Stream stream(with_delays(delays.exposure, delays.gain), kGains);
    const int most = std::max(delays.exposure, delays.gain);
    for (int i = 0; i < 30; ++i) {
      const MatchedFrame frame = stream.step();
      if (i < most) continue;
      CAPTURE(delays.exposure, delays.gain, i);
      REQUIRE(frame.evidence.claims.size() == 1);
      const Exposure& wanted = kGains[static_cast<std::size_t>(i - most) % 3];
      const Exposure claim = frame.evidence.claims[0].exposure;
      CHECK(claim == wanted);
      CHECK(stream.matcher().slot_of(frame.evidence.claims[0]) == (i - most) % 3);
      // and the sensor does what the prediction says
      CHECK(stream.requests()[static_cast<std::size_t>(i - delays.exposure)].exposure == wanted.time);
      CHECK(stream.requests()[static_cast<std::size_t>(i - delays.gain)].analogue_gain == wanted.gain);
    }
  }
}

TEST_CASE("pictures that show every prediction late or early shift it, within three frames", "[capture]") {
  constexpr Exposure kFour[] = {{1ms, 1}, {4ms, 1}, {8ms, 1}, {16ms, 1}};
  for (const std::span<const Exposure> cycle : {std::span<const Exposure>(kThree), {kFour}}) {
    for (int believed = 0; believed <= 4; ++believed) {
      for (int real = 0; real <= 4; ++real) {
        Stream stream(with_delays(believed, believed), cycle);  // of a sensor that takes `real` frames
        for (int i = 0; i < 40; ++i) {
          const MatchedFrame frame = stream.step();
          if (i < 8) continue;
          CAPTURE(cycle.size(), believed, real, i);
          const double truth = stream.wanted(i - real);
          REQUIRE(frame.evidence.claims.size() == 1);
          if (i >= 11) CHECK(frame.evidence.claims[0].log_value() == Approx(truth));
          stream.matcher().learn(truth);
        }
        const bool right = (believed - real) % static_cast<int>(cycle.size()) == 0;
        CHECK(stream.matcher().relocks() == (right ? 0 : 1));
        CHECK((stream.matcher().shift() == 0) == right);
        CHECK(stream.matcher().slot_of({cycle[0], 1, ExposureSource::Predicted}) == 0);
      }
    }
  }
}

TEST_CASE("of two shifts that explain the pictures the nearer one is taken", "[capture]") {
  constexpr Exposure kFour[] = {{1ms, 1}, {4ms, 1}, {8ms, 1}, {16ms, 1}};
  Stream stream(with_delays(2, 2), kFour);  // 3 frames late is one frame early
  for (int i = 0; i < 20; ++i) {
    stream.step();
    if (i >= 8) stream.matcher().learn(stream.wanted(i - 1));
  }
  CHECK(stream.matcher().shift() == 1);

  Stream two(with_delays(2, 2), std::span(kFour).first(2));  // late or early is one: a missed frame start
  for (int i = 0; i < 20; ++i) {
    two.step();
    if (i >= 8) two.matcher().learn(two.wanted(i - 1));
  }
  CHECK(two.matcher().shift() == -1);
}

TEST_CASE("a single late frame, or frames of one exposure, shift no prediction", "[capture]") {
  Stream stream(with_delays(1, 1));
  for (int i = 0; i < 60; ++i) {
    stream.step();
    if (i < 4) continue;
    stream.matcher().learn(stream.wanted(i % 7 == 0 ? i - 2 : i - 1));
    CHECK(stream.matcher().shift() == 0);
  }

  constexpr Exposure kLong[] = {{16ms, 1}, {16ms, 1}, {16ms, 1}, {1ms, 1}};
  Stream alike(with_delays(0, 0), kLong);
  for (int i = 0; i < 40; ++i) {
    alike.step();
    // The short frame is long: a frame late, or another lamp. Nobody saw the first one of the cycle.
    if (i % 4 != 0) alike.matcher().learn(alike.wanted(0));
  }
  CHECK(alike.matcher().relocks() == 0);
}

TEST_CASE("a cookie that comes again predicts nothing, and what it hides is not guessed", "[capture]") {
  for (int delay = 0; delay <= 2; ++delay) {
    Stream stream(with_delays(delay, delay));
    for (int i = 0; i < 24; ++i) {
      CapturedBuffer& buffer = stream.next();
      const bool repeats = i == 12;
      if (repeats) buffer.cookie = 11;
      const MatchedFrame frame = stream.match();
      CAPTURE(delay, i);
      CHECK(frame.cookie_repeated == repeats);
      CHECK(frame.lost_before == 0);
      if (i < delay) continue;
      if (i == 12 + delay) {
        CHECK(frame.evidence.claims.empty());
      } else {
        REQUIRE(frame.evidence.claims.size() == 1);
        CHECK(frame.evidence.claims[0].log_value() == Approx(stream.wanted(i - delay)));
      }
    }
  }
}

TEST_CASE("a control that was written late makes the frame doubtful that should show it", "[capture]") {
  constexpr Exposure kPairs[] = {{4ms, 1}, {4ms, 1}, {16ms, 1}, {16ms, 2}};
  for (int delay = 0; delay <= 2; ++delay) {
    for (int late = 8; late < 12; ++late) {
      Stream stream(with_delays(delay, delay), kPairs);
      for (int i = 0; i < 20; ++i) {
        stream.next().control_late = i == late;
        const MatchedFrame frame = stream.match();
        CAPTURE(delay, late, i);
        // Where the request before asked for the same, the frame shows it all the same.
        const bool changes = late % 4 != 1;
        CHECK(frame.evidence.prediction_doubtful == (i == late + delay && changes));
      }
    }
  }
}

TEST_CASE("controls that were late twice make even an exposure that stays doubtful", "[capture]") {
  constexpr Exposure kPairs[] = {{4ms, 1}, {4ms, 1}, {16ms, 1}};
  Stream stream(with_delays(0, 0), kPairs);
  for (int i = 0; i < 12; ++i) {
    stream.next().control_late = i == 6 || i == 7;
    const bool doubtful = stream.match().evidence.prediction_doubtful;
    CHECK(doubtful == (i == 6 || i == 7));
  }
}

TEST_CASE("a report without gain takes the gain from the prediction, or from a cycle of one gain",
          "[capture]") {
  constexpr Exposure kGains[] = {{1ms, 1}, {4ms, 2}, {16ms, 8}};
  struct Row {
    bool predicts, one_gain;
    std::optional<double> gain;  // of the report
    double want;                 // 0: no report
  };
  for (const Row& row : {Row{true, false, std::nullopt, 8}, Row{false, false, std::nullopt, 0},
                         Row{false, true, std::nullopt, 1}, Row{false, false, 3.0, 3},
                         Row{true, false, 3.0, 3}, Row{true, false, -1.0, 0}}) {
    CAPTURE(row.predicts, row.one_gain, row.want);
    FrameMatcherOptions options = with_delays(0, 0);
    if (!row.predicts) options.delays.reset();
    Stream stream(options, row.one_gain ? std::span<const Exposure>(kThree) : kGains);
    stream.step(), stream.step();
    CapturedBuffer& buffer = stream.next();
    buffer.exposure = 15ms, buffer.analogue_gain = row.gain, buffer.digital_gain = 1.5;
    const MatchedFrame frame = stream.match();
    const bool reports = row.want > 0;
    REQUIRE(frame.evidence.claims.size() == (reports ? 1u : 0u) + (row.predicts ? 1u : 0u));
    if (!reports) continue;
    const ExposureClaim& claim = frame.evidence.claims[0];
    CHECK(claim.exposure == Exposure{15ms, row.want});
    CHECK(claim.digital_gain == 1.5);
    CHECK(claim.source == ExposureSource::Reported);
  }
}

TEST_CASE("a pulse as long as the exposure tells when it began, one that marks a frame its time",
          "[capture]") {
  for (const StrobePulse kind : {StrobePulse::SpansExposure, StrobePulse::MarksFrame}) {
    Stream stream({.frame_duration = kAgreed, .strobe = kind, .strobe_after_timestamp = 2ms});
    for (int i = 0; i < 4; ++i) stream.pulse(1), stream.step();
    stream.pulse(0.9);
    const Instant driver = stream.next().timestamp;
    const MatchedFrame frame = stream.match();
    const Duration early = part_of(kAgreed, 1) - part_of(kAgreed, 0.9);
    REQUIRE(frame.strobed);
    if (kind == StrobePulse::MarksFrame) {
      CHECK(frame.timestamp == driver + -early);
      CHECK_FALSE(frame.opened);
      CHECK(frame.centre(4ms, 0ms) == driver + -early + 2ms);
    } else {
      CHECK(frame.timestamp == driver);
      CHECK(frame.opened == driver + -early + 2ms);
      CHECK(frame.evidence.strobe_width == Duration(4ms));
      CHECK(frame.centre(4ms, 0ms) == driver + -early + 4ms);
    }
    stream.pulse(0.7);  // nearer to no frame than a quarter of an interval
    CHECK_FALSE(stream.step().strobed);
    stream.pulse(1, Stream::Lost::Rise);
    CHECK_FALSE(stream.step().strobed);
  }
}

TEST_CASE("a frame that is taken after its strobe pulse was forgotten says so", "[capture]") {
  constexpr int kFrames = 200, kKept = SyncLine::kMostWaiting / 2;
  Stream stream({.frame_duration = kAgreed, .strobe = StrobePulse::MarksFrame});
  for (int i = 1; i <= kFrames; ++i) stream.pulse(i);
  for (int i = 1; i <= kFrames; ++i) {
    const MatchedFrame frame = stream.step();
    CHECK(frame.strobed == (i > kFrames - kKept));
    CHECK(frame.pulse_forgotten == !frame.strobed);
  }
  CHECK_FALSE(stream.step().pulse_forgotten);  // its pulse never came
}

TEST_CASE("where timestamps mark the end of exposures, pulses of every length are matched by their ends",
          "[capture]") {
  for (const Duration delay : {Duration(-2ms), Duration(0), Duration(1ms)}) {
    Stream stream({.frame_duration = kAgreed,
                   .strobe = StrobePulse::SpansExposure,
                   .strobe_after_timestamp = delay,
                   .timestamp_mark = TimestampMark::ExposureEnd});
    for (int i = 0; i < 12; ++i) {
      constexpr Duration kWidths[] = {1ms, 16ms, 30ms};
      const Duration width = kWidths[i % 3];
      const Instant rise = stream.next().timestamp + (delay - width);
      stream.edges_of(rise, width, i == 7 ? Stream::Lost::Fall : Stream::Lost::Neither);
      const MatchedFrame frame = stream.match();
      CAPTURE(to_seconds(delay), i);
      REQUIRE(frame.strobed == (i != 7));
      if (i == 7) continue;
      CHECK(frame.opened == rise);
      CHECK(frame.evidence.strobe_width == width);
    }
  }
}

TEST_CASE("of two slots with one exposure the request tells which it was", "[capture]") {
  constexpr Exposure kEqual[] = {{4ms, 1}, {2ms, 2}, {16ms, 1}};
  const ExposureClaim four{{4ms, 1}, 1, ExposureSource::Reported},
      nine{{9ms, 1}, 1, ExposureSource::Reported}, sixteen{{16ms, 1}, 1, ExposureSource::Photometric};
  Stream stream(with_delays(1, 1), kEqual);
  for (int i = 0; i < 12; ++i) {
    stream.step();
    if (i < 1) continue;
    CAPTURE(i);
    const int slot = (i - 1) % 3;
    CHECK(stream.matcher().slot_of(four) == (slot < 2 ? slot : -1));
    CHECK(stream.matcher().slot_of(sixteen) == 2);
    CHECK(stream.matcher().slot_of(nine) == -1);
  }

  Stream late(with_delays(1, 1), kEqual);  // of a sensor that takes two frames
  for (int i = 0; i < 20; ++i) {
    late.step();
    if (i >= 3) late.matcher().learn(late.wanted(i - 2));
    const int slot = (i + 1) % 3;
    if (i >= 8) CHECK(late.matcher().slot_of(four) == (slot < 2 ? slot : -1));
  }
}

TEST_CASE("under a rolling shutter the time of a frame is the middle of its middle row's exposure") {
  const Instant stamp{100ms};
  MatchedFrame frame;
  frame.timestamp = stamp;
  frame.mark = TimestampMark::ExposureBegin;
  CHECK(frame.centre(4ms, 12ms) == stamp + 8ms);
  frame.mark = TimestampMark::ExposureEnd;  // of the last row
  CHECK(frame.centre(4ms, 12ms) == stamp + -8ms);
  frame.opened = stamp + 1ms;
  CHECK(frame.centre(4ms, 12ms) == stamp + 9ms);
}

}  // namespace
}  // namespace hdrcam
