#include "hal/recording/sound_facts.h"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr PoseMatrix kHome{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

TEST_CASE("a lens has focal lengths in pixels and a centre near the picture") {
  const auto refused = [](Intrinsics lens) { return objection_to(lens, 320, 240).has_value(); };
  CHECK_FALSE(refused({300, 300, 160, 120}));
  CHECK_FALSE(refused({300, 310, -40, 500}));
  for (const double focal : {0., -300., 1e40, 0.8, kNan, HUGE_VAL}) {
    INFO(focal);
    CHECK(refused({focal, 300, 160, 120}));
    CHECK(refused({300, focal, 160, 120}));
  }
  for (const double centre : {1e9, -1e9, kNan, HUGE_VAL}) {
    INFO(centre);
    CHECK(refused({300, 300, centre, 120}));
    CHECK(refused({300, 300, 160, centre}));
  }
}

TEST_CASE("a pose is a rotation and a place on Earth") {
  CHECK_FALSE(objection_to(kHome));
  const double c = std::cos(0.3), s = std::sin(0.3);
  CHECK_FALSE(objection_to(PoseMatrix{c, 0, s, 12, 0, 1, 0, -3, -s, 0, c, 4e5}));
  PoseMatrix far = kHome, stretched = kHome, flat = kHome, mirrored = kHome, sheared = kHome, unknown = kHome;
  far[3] = 1e300, stretched[0] = 2, flat[10] = 0, mirrored[5] = -1, sheared[1] = 0.5, unknown[7] = kNan;
  for (const PoseMatrix& pose : {far, stretched, flat, mirrored, sheared, unknown}) CHECK(objection_to(pose));
}

TEST_CASE("frames come in the order of their numbers and of their times") {
  FrameFacts one, two;
  one.sequence = 4, one.timestamp = Instant::from_seconds(1);
  two.sequence = 5, two.timestamp = Instant::from_seconds(1.03);
  CHECK_FALSE(objection_to(one, nullptr));
  CHECK_FALSE(objection_to(two, &one));
  CHECK(objection_to(one, &two));
  CHECK(objection_to(one, &one));
  FrameFacts same_time = two;
  same_time.timestamp = one.timestamp;
  CHECK(objection_to(same_time, &one)->find("1.000000") != std::string::npos);
  FrameFacts same_number = two;
  same_number.sequence = 4;
  CHECK(objection_to(same_number, &one)->find("4") != std::string::npos);
}

}  // namespace
}  // namespace hdrcam
