// When a tracked camera is in another world.
#include "online/priors/pose/world_watch.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// A texture of its own, moved by so many pixels, brighter or darker.
ExposedFrame picture(double pattern, double moved_px = 0, double light = 1) {
  ExposedFrame frame;
  frame.codes = Image<float>(3, 96, 128);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < 96; ++y)
      for (int x = 0; x < 128; ++x) {
        const double u = x - moved_px;
        const double value =
            60 + 25 * std::sin(pattern * u) + 25 * std::cos(1.7 * pattern * y + 0.5 * pattern * u);
        frame.codes.at(c, y, x) = static_cast<float>(light * value);
      }
  return frame;
}

CameraPose tracked(bool lost = false) {
  CameraPose pose;
  pose.lost = lost;
  return pose;
}

constexpr double kHere = 0.06, kElsewhere = 0.1;

// Of a camera that saw one picture, then so many black ones.
WorldWatch after_black(int frames, const CameraPose& pose) {
  WorldWatch watch;
  watch.begin(picture(kHere));
  for (int i = 0; i < frames; ++i) REQUIRE_FALSE(watch.ends_before(picture(0, 0, 0), pose));
  return watch;
}

}  // namespace

TEST_CASE("a world goes on over other exposures and motion, and ends at a cut") {
  WorldWatch watch;
  watch.begin(picture(kHere));
  CHECK_FALSE(watch.ends_before(picture(kHere, 4, 2), tracked()));
  CHECK_FALSE(watch.ends_before(picture(kHere, 8, 0.5), tracked()));
  CHECK(watch.ends_before(picture(kElsewhere), tracked()));
}

TEST_CASE("a loss is bridged where the scene is the same and it was short") {
  const CameraPose lost = tracked(true);
  WorldWatch watch = after_black(15, lost);
  CHECK_FALSE(watch.ends_before(picture(kHere, 4), tracked()));
  CHECK_FALSE(watch.ends_before(picture(kHere, 8), tracked()));
  CHECK(after_black(3, lost).ends_before(picture(kElsewhere), tracked()));
  CHECK(after_black(16, lost).ends_before(picture(kHere, 4), tracked()));
}

TEST_CASE("a cut behind a few black frames is found, also where these are tracked as if nothing was") {
  for (const int black : {1, 3, 8}) {
    CAPTURE(black);
    CHECK(after_black(black, tracked()).ends_before(picture(kElsewhere), tracked()));
  }
  // that long ago tells nothing
  CHECK_FALSE(after_black(30, tracked()).ends_before(picture(kElsewhere), tracked()));
}

TEST_CASE("pictures that show too little to compare end no world") {
  WorldWatch watch;
  watch.begin(picture(kHere));
  CHECK_FALSE(watch.ends_before(picture(kElsewhere, 0, 0.01), tracked()));
  CHECK_FALSE(watch.ends_before(picture(kElsewhere, 0, 100), tracked()));
  CHECK_FALSE(watch.ends_before(picture(kHere), tracked()));
}

TEST_CASE("a world goes on over pictures that show nothing but noise, and ends at a cut behind them") {
  std::mt19937 random(5);
  std::normal_distribution<float> noise(16);
  const auto dark = [&] {
    ExposedFrame frame = picture(0, 0, 0);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < 96; ++y)
        for (int x = 0; x < 128; ++x) frame.codes.at(c, y, x) = std::round(noise(random));
    return frame;
  };
  WorldWatch watch;
  watch.begin(picture(kHere));
  for (int i = 0; i < 4; ++i) CHECK_FALSE(watch.ends_before(dark(), tracked()));
  CHECK_FALSE(watch.ends_before(picture(kHere, 4), tracked()));
  CHECK_FALSE(watch.ends_before(dark(), tracked()));
  CHECK(watch.ends_before(picture(kElsewhere), tracked()));
}
