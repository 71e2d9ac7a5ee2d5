// The frame duration that a camera keeps, from the times of its frames.
#include "capture/frame_interval.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kAgreed = 40ms;

TEST_CASE("the frame interval is the agreed one until three intervals say otherwise", "[capture]") {
  FrameInterval interval(kAgreed);
  for (int i = 0; i < 3; ++i) {
    CHECK(interval.value() == kAgreed);
    CHECK_FALSE(interval.measured());
    interval.observe(1, 50ms);
  }
  CHECK(interval.measured());
  CHECK(interval.value() == 50ms);
  CHECK(interval.frames_in(125ms) == Approx(2.5));
}

TEST_CASE("jitter of timestamps does not move the frame interval", "[capture]") {
  FrameInterval interval(kAgreed);
  for (int i = 0; i < 20; ++i) {
    interval.observe(1, i % 2 == 0 ? 39'300us : 40'700us);
    CHECK(interval.value() == kAgreed);
  }
}

TEST_CASE("frames that were lost do not lengthen the frame interval, counted or not", "[capture]") {
  FrameInterval interval(kAgreed);
  for (int i = 0; i < 20; ++i) {
    interval.observe(i % 3 == 0 ? 4 : 1, i % 3 == 0 ? 4 * kAgreed : kAgreed);
    if (i % 4 == 0) interval.observe(1, 2 * kAgreed);
    CHECK(interval.value() == kAgreed);
  }
}

}  // namespace
}  // namespace hdrcam
