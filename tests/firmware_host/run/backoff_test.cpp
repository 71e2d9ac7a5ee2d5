#include "firmware_host/run/backoff.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr double kSteady_ms = 10;

// Begins a wait. Returns the frames that it takes.
int waited(Backoff& backoff) {
  backoff.begin(kSteady_ms);
  int frames = 0;
  for (bool over = false; !over && frames < 100'000; ++frames) {
    CHECK_FALSE(backoff.is_over());
    over = backoff.pass();
    CHECK(over == backoff.is_over());
  }
  return frames;
}

TEST_CASE("a first wait takes four seconds, each further one twice as long, up to sixteen times the first") {
  Backoff backoff(1s);
  CHECK(backoff.is_over());
  CHECK_FALSE(backoff.pass());  // there is no wait that could end
  for (const int frames : {4, 8, 16, 32, 64, 64}) CHECK(waited(backoff) == frames);
  Backoff usual(33'333'333ns);
  CHECK(waited(usual) == 120);
}

TEST_CASE("a wait takes a frame at least, however long a frame is, and ten thousand at first at most") {
  Backoff slow(20s), fast(1us);
  CHECK(waited(slow) == 1);
  CHECK(waited(slow) == 2);
  CHECK(waited(fast) == 10'000);
}

TEST_CASE("the next wait may be made short again while one goes on, which stays as long as it was") {
  Backoff backoff(1s);
  CHECK(waited(backoff) == 4);
  CHECK(waited(backoff) == 8);
  backoff.begin(kSteady_ms);
  backoff.shorten_next();
  for (int frame = 1; frame < 16; ++frame) REQUIRE_FALSE(backoff.pass());
  CHECK(backoff.pass());
  CHECK(waited(backoff) == 4);

  backoff.begin(kSteady_ms);
  backoff.reset();
  CHECK(backoff.is_over());
  CHECK(waited(backoff) == 4);
}

TEST_CASE("a machine is faster that takes clearly less for the same work than when the wait began") {
  Backoff backoff(1s);
  backoff.begin(kSteady_ms);
  CHECK(backoff.is_machine_faster(0.84 * kSteady_ms));
  CHECK_FALSE(backoff.is_machine_faster(0.86 * kSteady_ms));
  backoff.begin(2 * kSteady_ms);
  CHECK(backoff.is_machine_faster(0.86 * kSteady_ms));
}

}  // namespace
}  // namespace hdrcam
