// At which frame of a stream another scene begins.
#include "online/pictures/cut_watch.h"

#include <cmath>
#include <random>

#include "tests/support/coded_frame.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 96, kCols = 128;
constexpr double kHere = 0.06, kElsewhere = 0.1;
constexpr float kShort = 1, kLong = 16;

double texture(double pattern, int x, int y) {
  return std::sin(pattern * x) + std::cos(1.7 * pattern * y + 0.5 * pattern * x);
}

ExposedFrame picture(float exposure, double pattern) {
  ExposedFrame frame = test::coded_frame(kRows, kCols, [&](int, int y, int x) {
    return exposure * static_cast<float>(60 + 25 * texture(pattern, x, y));
  });
  frame.exposure = exposure;
  return frame;
}

ExposedFrame plain(float code) {
  ExposedFrame frame = picture(kShort, kHere);
  frame.codes.fill(code);
  return frame;
}

// Of a camera that saw one picture, then so many black ones.
CutWatch after_black(int frames) {
  CutWatch watch;
  watch.begin(picture(kShort, kHere));
  for (int i = 0; i < frames; ++i) REQUIRE_FALSE(watch.ends_before(plain(0)));
  return watch;
}

// A bright scene over a dark corner, which is the lower third: all that the long exposure does not show
// white. sign: of the dark corner's texture.
ExposedFrame over_dark_corner(float exposure, int sign) {
  ExposedFrame frame = picture(exposure, kHere);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        const double dark = 4 + 1.5 * sign * texture(kHere, x, y);
        float& code = frame.codes.at(c, y, x);
        code = y < 2 * kRows / 3 ? std::fmin(code, 255.0f) : exposure * static_cast<float>(dark);
      }
  return frame;
}

}  // namespace

TEST_CASE("a cut is found with any exposure of the cycle, and once") {
  CutWatch watch;
  watch.begin(picture(1, kHere));
  for (const float exposure : {2.0f, 0.5f, 1.0f, 2.0f})
    CHECK_FALSE(watch.ends_before(picture(exposure, kHere)));
  CHECK(watch.ends_before(picture(0.5f, kElsewhere)));
  for (const float exposure : {1.0f, 2.0f, 0.5f})
    CHECK_FALSE(watch.ends_before(picture(exposure, kElsewhere)));
}

TEST_CASE(
    "what changes in the dark corner that two exposures both show is no cut where the whole is as before") {
  CutWatch watch;
  watch.begin(over_dark_corner(kShort, 1));
  CHECK_FALSE(watch.ends_before(over_dark_corner(kLong, 1)));
  CHECK_FALSE(watch.ends_before(over_dark_corner(kShort, -1)));
  CutWatch corner;  // which alone would be taken for a cut
  corner.begin(over_dark_corner(kLong, 1));
  CHECK(corner.ends_before(over_dark_corner(kShort, -1)));
}

TEST_CASE("a cut behind a few black frames is found") {
  for (const int black : {1, 3, 8}) {
    CAPTURE(black);
    CHECK(after_black(black).ends_before(picture(kShort, kElsewhere)));
  }
  // that long ago tells nothing
  CHECK_FALSE(after_black(30).ends_before(picture(kShort, kElsewhere)));
}

TEST_CASE("pictures that show too little to compare are no cut") {
  CutWatch watch;
  watch.begin(picture(kShort, kHere));
  CHECK_FALSE(watch.ends_before(picture(0.01f, kElsewhere)));
  CHECK_FALSE(watch.ends_before(picture(100, kElsewhere)));
  CHECK_FALSE(watch.ends_before(picture(kShort, kHere)));
}

TEST_CASE("a scene goes on over pictures that show nothing but noise, and ends at a cut behind them") {
  std::mt19937 random(5);
  std::normal_distribution<float> noise(16);
  const auto dark = [&] {
    ExposedFrame frame = plain(0);
    for (float& code : frame.codes.samples()) code = std::round(noise(random));
    return frame;
  };
  CutWatch watch;
  watch.begin(picture(kShort, kHere));
  for (int i = 0; i < 4; ++i) CHECK_FALSE(watch.ends_before(dark()));
  CHECK_FALSE(watch.ends_before(picture(kShort, kHere)));
  CHECK_FALSE(watch.ends_before(dark()));
  CHECK(watch.ends_before(picture(kShort, kElsewhere)));
}
