// What a sensor answers to trigger pulses.
#include "capture/trigger_ledger.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;
using Catch::Contains;

// A ledger that is told of pulses at 10 ms intervals, each answered 100 us later unless it is said otherwise.
struct Answered {
  Answered() { ledger.start({.mode = TriggerMode::FrameStart, .interval = 10ms}); }
  Instant begin(int i) const { return Instant::from_seconds(3) + 10ms * i; }
  void pulse(int i, bool late = false) {
    TriggerPulse pulse;
    pulse.planned.number = static_cast<std::uint64_t>(i);
    pulse.index = driven++;
    pulse.planned.begin = begin(i), pulse.planned.width = 200us;
    pulse.rise.at = begin(i), pulse.fall.at = begin(i) + 200us, pulse.late = late;
    ledger.pulse(pulse);
  }
  void answer(Instant when) {
    ledger.answer({when, true, edges++});
    ledger.answer({when + 1ms, false, edges++});
  }
  void lose_answer() { edges += 2; }
  void unrecorded_pulse() { ++driven; }
  TriggerLedger ledger;
  std::uint64_t driven = 0, edges = 0;
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
  const std::string text =
      sentence_of(counters, "FSYNC", {.mode = TriggerMode::FrameStart}, TriggerAnswers::Heard);
  CHECK_THAT(text,
             Contains("trigger 'FSYNC' (frame start): 198 pulses, 1 late (more than 500 us), 2 left out") &&
                 Contains("196 answered, 2 not (pulse 17, 120), 1 answer without a pulse"));
  CHECK_THAT(sentence_of(counters, "FSYNC", {}, TriggerAnswers::NotHeard), !Contains("answered"));
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

TEST_CASE("pulses without a record were driven, and their answers are no others'") {
  Answered line;
  line.pulse(0);
  line.answer(line.begin(0) + 100us);
  for (int i = 1; i < 9; ++i) {
    if (i == 4) continue;  // not driven
    line.unrecorded_pulse();
    if (i != 6) line.answer(line.begin(i) + 100us);
  }
  line.pulse(10);  // nor is 9
  line.answer(line.begin(10) + 100us);
  line.answer(line.begin(10) + 7ms);  // nobody asked
  line.pulse(11);
  line.answer(line.begin(11) + 100us);
  line.ledger.settle(line.begin(20));
  const TriggerCounters& counters = line.ledger.counters();
  CHECK(counters.pulses == 10);
  CHECK(counters.left_out == 2);
  CHECK(counters.answered == 9);
  CHECK(counters.unanswered == 0);
  CHECK(counters.spurious == 1);

  line.unrecorded_pulse();
  line.answer(line.begin(12) + 100us);
  line.ledger.end(line.driven);
  line.ledger.settle(line.begin(20));
  CHECK(counters.pulses == 11);
  CHECK(counters.answered == 10);
  CHECK(counters.spurious == 1);
}

TEST_CASE("a pulse whose answer may be among edges that the line lost is not said to be unanswered") {
  Answered line;
  for (int i = 0; i < 10; ++i) {
    line.pulse(i);
    if (i >= 3 && i <= 6)
      line.lose_answer();
    else if (i != 8)
      line.answer(line.begin(i) + 100us);
  }
  line.ledger.settle(line.begin(20));
  const TriggerCounters& counters = line.ledger.counters();
  CHECK(counters.pulses == 10);
  CHECK(counters.answered == 5);
  CHECK(counters.unanswered == 1);
  CHECK(counters.missing[0] == 8);
  CHECK(counters.spurious == 0);
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

}  // namespace
}  // namespace hdrcam
