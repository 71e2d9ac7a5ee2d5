// Inbox and governor together, on a machine of known costs and a camera of 30 frames/s, in a time of their
// own.
#include <algorithm>

#include "firmware_host/live/fit_inbox.h"
#include "tests/firmware_host/run/governed_machine.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

constexpr double kInterval_ms = 1e3 / 30;
constexpr int kSlots = 3;

struct Outcome {
  int emitted = 0, left_out = 0, shed = 0, as_asked = 0;
  double longest_latency_ms = 0;
};

// The first frame of the fit takes start_ms, one in hiccup_every takes hiccup_ms more.
struct Story {
  test::Machine machine;
  double start_ms = 0;
  int hiccup_every = 1 << 30;
  double hiccup_ms = 0;
};

Outcome run_of(Story story, int frames) {
  FramePool pool(128);
  FitInbox inbox(kSlots, 30);
  Governor governor(test::ladder(), test::kDeadline);
  Outcome seen;
  double now_ms = 0;
  int captured = 0, fitted = 0;
  const auto capture_until_now = [&] {
    for (; captured < frames && captured * kInterval_ms <= now_ms; ++captured) {
      FrameShare frame = pool.take();
      REQUIRE(frame);
      frame->captured.raw.facts.sequence = static_cast<std::uint64_t>(captured);
      frame->captured.raw.facts.slot = captured % kSlots;
      seen.shed += inbox.put(std::move(frame));
    }
  };
  while (true) {
    capture_until_now();
    const FitInbox::Taken taken = inbox.take(Duration{0});
    seen.shed += taken.shed;
    if (!taken.frame) {
      if (captured == frames) return seen;
      now_ms = captured * kInterval_ms;
      continue;
    }
    seen.as_asked += governor.rung() == 0;
    const FrameBudget budget = governor.next();
    FrameWork work = story.machine.work(budget, false);
    if (fitted == 0) work.total_ms += story.start_ms;
    if (++fitted % story.hiccup_every == 0) work.total_ms += story.hiccup_ms;
    now_ms += work.total_ms;
    capture_until_now();
    governor.done(work, inbox.backlog());
    ++(budget.emits ? seen.emitted : seen.left_out);
    const double arrived_ms = static_cast<double>(taken.frame->captured.raw.facts.sequence) * kInterval_ms;
    seen.longest_latency_ms = std::max(seen.longest_latency_ms, now_ms - arrived_ms);
  }
}

TEST_CASE("a slow start and single long frames lose no frame, at whatever load a rung is in time") {
  constexpr int kFrames = 1800;
  for (const double load : {0.8, 1.0, 1.3, 1.7, 2.2, 2.5}) {
    const Outcome seen = run_of(
        {.machine = {.load = load, .noise = 0.08}, .start_ms = 600, .hiccup_every = 200, .hiccup_ms = 150},
        kFrames);
    CAPTURE(load, seen.shed, seen.left_out, seen.longest_latency_ms);
    CHECK(seen.emitted == kFrames);
    CHECK(seen.longest_latency_ms < 800);
    if (load <= 1) CHECK(seen.as_asked > kFrames / 2);
  }
}

TEST_CASE("a machine that is slower than the cheapest rung leaves frames out before any is shed") {
  constexpr int kFrames = 1800;
  const Outcome seen = run_of({.machine = {.load = 3.5, .noise = 0.05}}, kFrames);
  CAPTURE(seen.shed, seen.left_out, seen.longest_latency_ms);
  CHECK(seen.emitted + seen.left_out + seen.shed == kFrames);
  CHECK(seen.left_out > 0);
  CHECK(seen.shed < kFrames / 10);
  CHECK(seen.longest_latency_ms < 1200);
}

TEST_CASE("where no rung is in time, no frame is old, and the latency stays that of one cycle") {
  constexpr int kFrames = 1800;
  const Outcome seen = run_of({.machine = {.load = 7, .noise = 0.05}}, kFrames);
  CHECK(seen.shed > kFrames / 4);
  const Outcome longer = run_of({.machine = {.load = 7, .noise = 0.05}}, 2 * kFrames);
  CHECK(longer.longest_latency_ms < 1300);
  CHECK(longer.longest_latency_ms <= seen.longest_latency_ms * 1.1);
}

}  // namespace
}  // namespace hdrcam
