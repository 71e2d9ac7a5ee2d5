#include "online/response/smeared_white.h"

#include "tests/support/coded_frame.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 60, kCols = 80;

// Light on the left, up to a column, of which every tenth pixel of the longer exposure has this code.
struct Pictures {
  int light_cols = 40, moved_px = 0;
  float every_tenth = 240;
  float beside_it = 230;  // code of the longer exposure

  Image<float> shorter() const {
    return test::coded_frame(
               kRows, kCols,
               [&](int, int, int x) { return x < light_cols ? 160.f + static_cast<float>(x) : 20.f; })
        .codes;
  }
  Image<float> longer() const {
    return test::coded_frame(kRows, kCols,
                             [&](int, int y, int x) {
                               if (x >= light_cols - moved_px) return beside_it;
                               return (y * kCols + x) % 10 == 3 ? every_tenth : 255.f;
                             })
        .codes;
  }
  double share() const {
    const Image<float> dark = shorter(), light = longer();
    SmearedWhite smeared;
    for (int frames = 0; frames < 4; ++frames) smeared.add({dark, 1, 1}, {light, 1, 1});
    return smeared.share();
  }
};

}  // namespace

TEST_CASE("codes below white are counted where the shorter exposure is far brighter than white") {
  CHECK(Pictures{}.share() == Approx(0.1).margin(0.02));
  CHECK(Pictures{.every_tenth = 255}.share() == 0);
}

TEST_CASE("what moved between two exposures is not taken for a white that is smeared") {
  CHECK(Pictures{.moved_px = 2, .every_tenth = 255}.share() == 0);
  CHECK(Pictures{.moved_px = 12, .every_tenth = 255, .beside_it = 100}.share() ==
        0);  // another light is seen there
}

TEST_CASE("a picture that is hardly white, or nearly all of it, tells nothing of a smeared white") {
  CHECK(Pictures{.light_cols = 1}.share() == 0);
  CHECK(Pictures{.light_cols = kCols}.share() > 0);
  CHECK(Pictures{.light_cols = kCols, .every_tenth = 255}.share() == 0);
}
