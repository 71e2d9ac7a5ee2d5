// The governor against a machine of known costs and a clock of its own: nothing here measures a time.
#include "firmware_host/run/governor.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "tests/firmware_host/run/governed_machine.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using test::kDeadline;
using test::ladder;
using test::Machine;

constexpr int kSecond = 30;  // frames

struct Stretch {
  int late = 0, changes = 0;
  std::optional<int> first_as_asked;  // frame
};

Stretch run(Governor& governor, Machine& machine, int frames) {
  Stretch seen;
  const int late_before = governor.late();
  for (int i = 0; i < frames; ++i) {
    if (governor.rung() == 0 && !seen.first_as_asked) seen.first_as_asked = i;
    const int before = governor.rung();
    const bool previews = governor.previews();
    governor.done(machine.work(governor.next(), previews));
    seen.changes += governor.rung() != before;
  }
  seen.late = governor.late() - late_before;
  return seen;
}

TEST_CASE(
    "a run sheds previews first, then the field, the flow, the look-ahead, motion blur, shrinkage, and "
    "emitted frames last") {
  std::vector<std::string> names;
  const std::vector<Rung> rungs = ladder();
  for (const Rung& rung : rungs) names.push_back(rung.name);
  CHECK(names == std::vector<std::string>{"as asked", "no previews", "1 step of the fit", "no field",
                                          "one later frame", "flow medium", "flow fast",
                                          "flow over clipped parts coarse", "fewer shrinkage tiles",
                                          "no look-ahead", "no motion blur", "flow coarse", "no shrinkage",
                                          "3 frames in 4", "1 frame in 2"});
  for (std::size_t r = 0; r + 2 < rungs.size(); ++r) CHECK(rungs[r].emits_all());
  CHECK(rungs.front().previews);
  CHECK(rungs.front().budget.fit.steps == 2);
  const Rung& last = rungs.back();
  CHECK_FALSE(last.previews);
  CHECK(last.budget.field_rests);
  CHECK(last.budget.flow == FlowQuality::Coarse);
  CHECK(last.budget.flow_over_clipped == FlowQuality::Coarse);
  CHECK(last.budget.later_frames == 0);
  CHECK(last.budget.shrinkage == ShrinkageEffort::Off);
  CHECK_FALSE(last.budget.blurs);
  CHECK(last.emitted == 1);
  CHECK(last.of == 2);
}

TEST_CASE("what a run does not have it does not shed, and a field that is shown never rests") {
  const FrameBudget cheap{.flow = FlowQuality::Coarse,
                          .fit = {.steps = 30},
                          .later_frames = 0,
                          .blurs = false,
                          .shrinkage = ShrinkageEffort::Off};
  const std::vector<Rung> none = budget_ladder(cheap, FieldUse::None, PreviewUse::None);
  REQUIRE(none.size() == 3);
  CHECK(none[1].name == "3 frames in 4");
  const std::vector<Rung> seen = budget_ladder(cheap, FieldUse::Seen, PreviewUse::None);
  REQUIRE(seen.size() == 5);
  CHECK(seen[1].name == "7 steps of the fit");
  CHECK(seen[2].name == "1 step of the fit");
  CHECK_FALSE(seen.back().budget.field_rests);
}

TEST_CASE("a run with time enough begins cheaply, is as asked within two seconds and never sheds") {
  for (const double noise : {0.0, 0.08}) {
    Governor governor(ladder(), kDeadline);
    Machine machine{.noise = noise};
    CHECK(governor.ladder()[static_cast<std::size_t>(governor.rung())].name == "no shrinkage");
    const Stretch start = run(governor, machine, 2 * kSecond);
    REQUIRE(start.first_as_asked);
    CHECK(start.late == 0);
    CHECK(start.changes >= 3);  // a few rungs at a time: no cost is known yet
    CHECK(run(governor, machine, 100 * kSecond).changes == 0);
  }
}

TEST_CASE("a deadline that is far away costs no quality after the first few frames") {
  Governor governor(ladder(), std::chrono::seconds(10));
  Machine machine;
  const Stretch start = run(governor, machine, 10);
  REQUIRE(start.first_as_asked);
  CHECK(*start.first_as_asked <= 6);
  CHECK(start.changes == 1);
}

TEST_CASE("single frames that come late are no reason to shed") {
  Governor governor(ladder(), kDeadline);
  Machine machine{.noise = 0.05};
  run(governor, machine, 2 * kSecond);
  machine.spike_every = 20;
  const Stretch stretch = run(governor, machine, 100 * kSecond);
  CHECK(stretch.changes == 0);
  CHECK(stretch.late == 100 * kSecond / 20);
}

// For 30 s. Of frames whose time varies some are late, because a rung may fill .95 of the deadline. Just
// below the last rungs frames are late in turn, but not in the mean, and none is left out for that.
struct Load {
  double load, noise;
  int most_late;
};

TEST_CASE("a load of thirty seconds costs a few late frames, and quality is back within two seconds") {
  const Load kLoads[] = {{1.4, 0, 4},     {1.7, 0, 4},     {2.0, 0, 4},     {2.6, 0, 4},
                         {3.2, 0, 4},     {1.4, 0.08, 45}, {1.7, 0.08, 45}, {2.0, 0.08, 45},
                         {2.6, 0.08, 45}, {3.2, 0.08, 225}};
  for (const auto& [load, noise, most_late] : kLoads) {
    Governor governor(ladder(), kDeadline);
    Machine machine{.noise = noise};
    run(governor, machine, 10 * kSecond);
    REQUIRE(governor.rung() == 0);
    machine.load = load;
    const Stretch loaded = run(governor, machine, 30 * kSecond);
    CAPTURE(load, noise, loaded.changes, governor.rung());
    CHECK(loaded.late <= most_late);
    CHECK(governor.rung() > 0);
    machine.load = 1;
    const Stretch after = run(governor, machine, 10 * kSecond);
    REQUIRE(after.first_as_asked);
    CHECK(*after.first_as_asked <= 2 * kSecond);
    CHECK(after.late <= 2);
  }
}

TEST_CASE(
    "a machine that is too slow for any rung emits all that it works on, and sheds again when it is faster") {
  Governor governor(ladder(), kDeadline);
  const int emits_all = governor.rung(), last = static_cast<int>(governor.ladder().size()) - 1;
  Machine machine{.load = 6, .noise = 0.05};  // 50 ms for state and motion alone
  run(governor, machine, 10 * kSecond);
  const std::vector<int> before = governor.frames_at();
  run(governor, machine, 60 * kSecond);
  CHECK(governor.frames_at()[static_cast<std::size_t>(emits_all)] -
            before[static_cast<std::size_t>(emits_all)] >
        50 * kSecond);
  machine.load = 3.5;  // 28 ms without any emission, 35 with it
  run(governor, machine, 10 * kSecond);
  CHECK(governor.rung() > emits_all);
  CHECK(run(governor, machine, 10 * kSecond).late < kSecond);
  machine.load = 1;
  run(governor, machine, 10 * kSecond);
  CHECK(governor.rung() == 0);
  CHECK(last > emits_all);
}

TEST_CASE("under a steady load the rung stays, wherever between two rungs the load lies") {
  for (int step = 0; step < 30; ++step) {
    Governor governor(ladder(), kDeadline);
    const int emits_all = governor.rung();
    Machine machine{.load = 0.9 + 0.08 * step, .noise = 0.08};
    run(governor, machine, 10 * kSecond);
    const Stretch stretch = run(governor, machine, 100 * kSecond);
    CAPTURE(machine.load, governor.rung(), stretch.late);
    CHECK(stretch.changes <= 14);
    if (governor.rung() + 1 < static_cast<int>(governor.ladder().size()))
      CHECK(stretch.late <= 100 * kSecond / (governor.rung() == emits_all ? 8 : 32));
  }
}

TEST_CASE("frames of uneven cost that are in time in the mean are all emitted") {
  Governor governor(ladder(), kDeadline);
  const int emits_all = governor.rung();
  Machine machine{.load = 3.12, .noise = 0.08};
  run(governor, machine, 10 * kSecond);
  const std::vector<int> before = governor.frames_at();
  run(governor, machine, 20 * kSecond);
  int left_out = 0;
  for (std::size_t r = static_cast<std::size_t>(emits_all) + 1; r < before.size(); ++r)
    left_out += governor.frames_at()[r] - before[r];
  CHECK(left_out < kSecond);
}

TEST_CASE(
    "frames of uneven cost count as their mean where a queue evens them out, and else all are in time") {
  for (const Backlog backlog : {Backlog::None, Backlog::Unknown}) {
    Governor governor(ladder(), kDeadline);
    Machine machine{.noise = 0.03, .third = 1.4};  // as asked 26.6, 26.6 and 37.2 ms
    const auto go_on_beside = [&](Backlog now, int frames) {
      for (int i = 0; i < frames; ++i) governor.done(machine.work(governor.next(), governor.previews()), now);
    };
    go_on_beside(backlog, 4 * kSecond);
    const int before = governor.late(), as_asked = governor.frames_at().front();
    go_on_beside(backlog, 20 * kSecond);
    CAPTURE(governor.rung(), governor.late() - before);
    if (backlog == Backlog::None) {
      CHECK(governor.frames_at().front() - as_asked == 20 * kSecond);
      go_on_beside(Backlog::Waiting, 4 * kSecond);
      CHECK(governor.frames_at().front() - as_asked == 24 * kSecond);
    } else {
      CHECK(governor.rung() > 0);
      CHECK(governor.late() - before < kSecond);
    }
  }
}

TEST_CASE("as the load grows, what is shed follows the order, and comes back in the opposite one") {
  Governor governor(ladder(), kDeadline);
  Machine machine;
  run(governor, machine, 2 * kSecond);
  REQUIRE(governor.rung() == 0);
  int worst = 0;
  for (; machine.load < 3.65; machine.load += 0.05) {
    run(governor, machine, kSecond);
    CHECK(governor.rung() >= worst);
    worst = std::max(worst, governor.rung());
  }
  CHECK(worst == static_cast<int>(governor.ladder().size()) - 1);
  for (; machine.load > 1; machine.load -= 0.05) {
    run(governor, machine, 2 * kSecond);
    CHECK(governor.rung() <= worst);
    worst = std::min(worst, governor.rung());
  }
  CHECK(worst <= 1);
}

TEST_CASE("no frame is missed from the count: each is at one rung") {
  Governor governor(ladder(), kDeadline);
  Machine machine{.load = 2};
  governor.done({.frames = 0});
  governor.done({.frames = 6, .total_ms = 400, .steady_ms = 40});
  CHECK(governor.late() == 0);  // six frames at once: the start, not a late frame
  run(governor, machine, 100);
  int all = 0;
  for (const int frames : governor.frames_at()) all += frames;
  CHECK(all == 106);
  const auto present = static_cast<std::size_t>(governor.rung());
  const int before = governor.frames_at()[present];
  governor.ended(2);
  CHECK(governor.frames_at()[present] == before + 2);
}

TEST_CASE(
    "one frame in two is emitted where nothing cheaper is left, and every frame takes part in the state") {
  Governor governor(ladder(), kDeadline);
  Machine machine{.load = 3.6};
  run(governor, machine, 4 * kSecond);
  REQUIRE(governor.ladder()[static_cast<std::size_t>(governor.rung())].of == 2);
  int emitted = 0;
  for (int i = 0; i < 20; ++i) {
    const FrameBudget budget = governor.next();
    emitted += budget.emits;
    governor.done(machine.work(budget, false));
  }
  CHECK(emitted == 10);
}

TEST_CASE("of the frames that take part one in two is emitted, also where every second one is kept out") {
  Governor governor(ladder(), kDeadline);
  Machine machine{.load = 3.6};
  run(governor, machine, 4 * kSecond);
  REQUIRE(governor.ladder()[static_cast<std::size_t>(governor.rung())].of == 2);
  int emitted = 0;
  for (int i = 0; i < 20; ++i) {
    governor.done({});  // kept out of the fit
    const FrameBudget budget = governor.next();
    emitted += budget.emits;
    governor.done(machine.work(budget, false));
  }
  CHECK(emitted == 10);
}

TEST_CASE("a queue that absorbs late frames: none is left out, and quality waits until it is empty") {
  Governor governor(ladder(), kDeadline);
  const int emits_all = governor.rung();
  Machine machine{.load = 3.6, .noise = 0.05};  // 36 ms on the cheapest rung that emits all
  const auto go_on = [&](int frames, Backlog backlog) {
    for (int i = 0; i < frames; ++i) governor.done(machine.work(governor.next(), false), backlog);
  };
  go_on(4 * kSecond, Backlog::None);
  CHECK(governor.rung() == emits_all);
  go_on(kSecond, Backlog::Pressing);
  CHECK(governor.rung() > emits_all);

  Governor another(ladder(), kDeadline);
  machine = {};
  const auto go_on_with = [&](int frames, Backlog backlog) {
    for (int i = 0; i < frames; ++i) another.done(machine.work(another.next(), false), backlog);
  };
  go_on_with(kSecond, Backlog::Waiting);
  CHECK(another.rung() == emits_all);
  go_on_with(2 * kSecond, Backlog::None);
  CHECK(another.rung() == 0);  // 26.6 ms: in time, and too long to work off a queue
  go_on_with(kSecond, Backlog::Waiting);
  CHECK(another.rung() == 0);
  machine.load = 1.1;
  go_on_with(kSecond, Backlog::Pressing);
  CHECK(another.rung() > 0);
}

}  // namespace
}  // namespace hdrcam
