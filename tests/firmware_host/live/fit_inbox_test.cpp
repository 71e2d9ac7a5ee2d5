#include "firmware_host/live/fit_inbox.h"

#include <set>
#include <vector>

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

constexpr Duration kNoWait{0};

// Frame n of a camera that walks through `slots` exposures.
FrameShare frame_of(FramePool& pool, std::uint64_t sequence, int slots) {
  FrameShare frame = pool.take();
  REQUIRE(frame);
  frame->captured.raw.facts.sequence = sequence;
  frame->captured.raw.facts.slot = static_cast<int>(sequence % static_cast<std::uint64_t>(slots));
  return frame;
}

TEST_CASE("a fit that keeps up gets every frame") {
  FramePool pool(12);
  FitInbox inbox(3, 7);
  for (std::uint64_t n = 0; n < 50; ++n) {
    CHECK(inbox.put(frame_of(pool, n, 3)) == 0);
    const auto taken = inbox.take(kNoWait);
    REQUIRE(taken.frame);
    CHECK(taken.frame->captured.raw.facts.sequence == n);
    CHECK(taken.shed == 0);
    CHECK(inbox.backlog() == Backlog::None);
  }
}

TEST_CASE("frames wait for a fit that is late for a moment, and it gets them all, in order") {
  FramePool pool(32);
  FitInbox inbox(3, 20);
  std::uint64_t captured = 0, fitted = 0;
  const auto capture = [&](int frames) {
    for (int i = 0; i < frames; ++i) CHECK(inbox.put(frame_of(pool, captured++, 3)) == 0);
  };
  const auto fit = [&](int frames) {
    for (int i = 0; i < frames; ++i) {
      const auto taken = inbox.take(kNoWait);
      REQUIRE(taken.frame);
      CHECK(taken.frame->captured.raw.facts.sequence == fitted++);
      CHECK(taken.shed == 0);
    }
  };
  for (int stall = 0; stall < 5; ++stall) {
    capture(15);
    fit(1);
    CHECK(inbox.backlog() == Backlog::Pressing);
    for (int i = 0; i < 10; ++i) capture(1), fit(2);
    CHECK(inbox.backlog() == Backlog::Lasting);
    fit(4);
    CHECK(inbox.backlog() == Backlog::None);
  }
}

TEST_CASE("a fit that does not catch up is not waited for, until it has kept up for as long") {
  FramePool pool(32);
  constexpr int kMost = 12;
  FitInbox inbox(2, kMost);
  std::uint64_t captured = 0;
  const auto capture = [&] { return inbox.put(frame_of(pool, captured++, 2)); };
  for (int i = 0; i < 3; ++i) capture();
  int shed = 0;
  for (int i = 3; i < 3 * kMost; ++i) {  // as fast as the camera, and three frames late
    CHECK(shed == 0);
    capture();
    shed += inbox.take(kNoWait).shed;
  }
  CHECK(shed == 2);
  CHECK(inbox.backlog() == Backlog::Pressing);
  for (int i = 0; i < 3 * kMost - 1; ++i) {
    while (inbox.take(kNoWait).frame) {
    }
    CHECK(inbox.backlog() == (i < kMost / 4 ? Backlog::Pressing : Backlog::None));
    capture();
  }
  for (int i = 0; i < 4; ++i) capture();
  CHECK(inbox.take(kNoWait).shed == 0);  // frames wait again
}

TEST_CASE("a fit that is slower than the camera still gets every exposure in turn, and none that is old") {
  for (const int slots : {1, 2, 3, 4})
    for (const int slower : {2, 3, 4, 6}) {
      INFO(slots << " slots, camera " << slower << " times as fast as the fit");
      FramePool pool(32);
      FitInbox inbox(slots, 2 * slots + 1);
      std::vector<std::uint64_t> fitted;
      std::uint64_t shed = 0, next = 0;
      for (int round = 0; round < 60; ++round) {
        for (int i = 0; i < slower; ++i)
          shed += static_cast<std::uint64_t>(inbox.put(frame_of(pool, next++, slots)));
        const auto taken = inbox.take(kNoWait);
        REQUIRE(taken.frame);
        shed += static_cast<std::uint64_t>(taken.shed);
        fitted.push_back(taken.frame->captured.raw.facts.sequence);
        if (shed > 0) CHECK(next - fitted.back() <= static_cast<std::uint64_t>(slots + slower));
      }
      for (std::size_t i = 1; i < fitted.size(); ++i) {
        CHECK(fitted[i] > fitted[i - 1]);
        CHECK((fitted[i] - fitted[i - 1]) % static_cast<std::uint64_t>(slots) ==
              1 % static_cast<unsigned>(slots));
      }
      std::uint64_t left = 0;
      while (true) {
        const auto taken = inbox.take(kNoWait);
        shed += static_cast<std::uint64_t>(taken.shed);
        if (!taken.frame) break;
        ++left;
      }
      CHECK(fitted.size() + left + shed == next);
    }
}

TEST_CASE("frames that are not of the schedule wait their turn, and the oldest goes when the inbox is full") {
  FramePool pool(32);
  FitInbox inbox(2, 5);
  int shed = 0;
  for (std::uint64_t n = 0; n < 9; ++n) {
    FrameShare frame = frame_of(pool, n, 2);
    frame->captured.raw.facts.slot = -1;
    shed += inbox.put(std::move(frame));
  }
  CHECK(shed == 4);
  for (std::uint64_t n = 4; n < 9; ++n) {
    const auto taken = inbox.take(kNoWait);
    REQUIRE(taken.frame);
    CHECK(taken.frame->captured.raw.facts.sequence == n);
  }
}

TEST_CASE("a closed inbox gives what it has and then ends at once") {
  FramePool pool(4);
  FitInbox inbox(3, 7);
  inbox.put(frame_of(pool, 0, 3));
  inbox.close();
  CHECK_FALSE(inbox.ended());
  CHECK(inbox.take(std::chrono::hours(1)).frame);
  CHECK(inbox.ended());
  CHECK_FALSE(inbox.take(std::chrono::hours(1)).frame);
}

}  // namespace
}  // namespace hdrcam
