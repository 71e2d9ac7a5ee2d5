// Whether two pictures of different exposure show one scene.
#include "online/pictures/same_scene.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr float kBlack = 16;  // codes

// A texture of its own in these channels, so bright; in the others black. Noise of one code.
ExposedFrame picture(double pattern, float light, std::initializer_list<int> channels) {
  std::mt19937 random(static_cast<unsigned>(1000 * light));
  std::normal_distribution<float> noise;
  ExposedFrame frame;
  frame.codes = Image<float>(3, 96, 128);
  for (int c = 0; c < 3; ++c) {
    const bool lit = std::ranges::find(channels, c) != channels.end();
    for (int y = 0; y < 96; ++y)
      for (int x = 0; x < 128; ++x) {
        const double texture = 2 + std::sin(pattern * x) + std::cos(1.7 * pattern * y + 0.5 * pattern * x);
        const float code = kBlack + (lit ? light * static_cast<float>(texture) : 0) + noise(random);
        frame.codes.at(c, y, x) = std::round(code);
      }
  }
  return frame;
}

constexpr double kHere = 0.06, kElsewhere = 0.1;

}  // namespace

TEST_CASE("a dark picture that shows its scene in one channel alone is of that scene") {
  for (const int lit : {0, 1, 2}) {
    INFO("lit channel " << lit);
    const ExposedFrame dark = picture(kHere, 3, {lit});
    CHECK(shows_one_scene(dark, picture(kHere, 40, {0, 1, 2})));
    CHECK_FALSE(shows_one_scene(dark, picture(kElsewhere, 40, {0, 1, 2})));
  }
}

TEST_CASE("pictures that are clipped, or of one code, are of any scene") {
  const ExposedFrame scene = picture(kHere, 40, {0, 1, 2});
  for (const float code : {255.f, kBlack}) {
    ExposedFrame plain = picture(kHere, 40, {0, 1, 2});
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < 96; ++y)
        for (int x = 0; x < 128; ++x) plain.codes.at(c, y, x) = code;
    CHECK(shows_one_scene(scene, plain));
  }
}

TEST_CASE("noise alone shows no scene") {
  std::vector<float> scratch;
  constexpr std::size_t kFewest = 64;
  CHECK_FALSE(shows_scene(thumbnail_of(picture(kHere, 0, {}), 1, scratch), kFewest));
  CHECK(shows_scene(thumbnail_of(picture(kHere, 3, {2}), 1, scratch), kFewest));
}
