#include "online/response/histogram_matches.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "online/response/response.h"
#include "tests/support/coded_frame.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr float kRatio = 32;  // of the exposures

// A frame of that light, noise of read electrons of 2000 on it, behind a response of gamma 2.2.
template <class Light>
ExposedFrame recorded(float exposure, double read, Light&& light) {
  const Response response = Response::gamma(2.2f);
  std::uint64_t pixel = static_cast<std::uint64_t>(exposure) << 32;
  ExposedFrame frame = test::coded_frame(192, 256, [&](int c, int y, int x) {
    const double noise = read / 2000 * test::MovingScene::noise(++pixel);
    const double seen = std::clamp(static_cast<double>(exposure) * light(y, x) + noise, 0.0, 1.0);
    return std::round(response.code_of(c, static_cast<float>(seen)));
  });
  frame.exposure = exposure;
  return frame;
}

template <class Light>
CodeMatches compared(double read, Light&& light) {
  HistogramMatches matches;
  REQUIRE(matches.add(recorded(1, read, light), recorded(kRatio, read, light), SceneCuts::None));
  return matches.of(1).begin()->second;
}
template <class Light>
std::vector<CodeMatch> matched(double read, Light&& light) {
  return compared(read, light).codes;
}

// How far the exposures of a match's codes are from the true ratio, stops.
double stops_off(const CodeMatch& match) {
  const Response response = Response::gamma(2.2f);
  return std::log2(response.exposure_of(1, match.z2) / response.exposure_of(1, match.z1) / kRatio);
}

}  // namespace

TEST_CASE("codes that only noise makes bright are not matched with what is brighter") {
  // A dark half and a bright one with nothing between them: the short frame sees the dark one in its noise,
  // whose upper half matched the brightest of it.
  const auto light = [](int, int x) {
    return x < 128 ? 0.004 * std::exp2(0.01 * x) : 0.2 * std::exp2(0.01 * (x - 128));
  };
  double squares = 0;
  int compared = 0;
  for (const CodeMatch& match : matched(6, light))
    if (match.z1 >= 12 && match.z2 <= 240) squares += stops_off(match) * stops_off(match), ++compared;
  REQUIRE(compared > 100);
  CAPTURE(compared);
  CHECK(std::sqrt(squares / compared) < 0.25);  // .42 without medians
}

TEST_CASE("small lights, which neighbour medians take away, are matched where both frames show hardly more") {
  const auto light = [](int y, int x) {
    return y % 4 == 0 && x % 4 == 0 ? 0.004 * std::exp2(y * 0.01) : 0.0;
  };
  const std::vector<CodeMatch> found = matched(0, light);
  int usable = 0;
  for (const CodeMatch& match : found)
    if (match.z1 >= 12 && match.z2 <= 245) {
      CHECK(stops_off(match) == Approx(0).margin(0.2));
      ++usable;
    }
  CHECK(usable > 5);
}

TEST_CASE("where no pixel has the light between two codes, none of it is matched, and white never is") {
  // a dark and a bright half, without noise; in the second scene the bright one is white in the long exposure
  struct Scene {
    double dark, bright, per_column;
  };
  for (const Scene& scene : {Scene{0.001, 0.02, 0.004}, {0.004, 0.2, 0.01}}) {
    const std::vector<CodeMatch> found = matched(0, [&](int, int x) {
      return x < 128 ? scene.dark * std::exp2(scene.per_column * x)
                     : scene.bright * std::exp2(scene.per_column * (x - 128));
    });
    CAPTURE(scene.bright);
    CHECK(found.size() > 50);
    for (const CodeMatch& match : found) {
      CAPTURE(match.z1, match.z2);
      CHECK(match.z2 < 254);
      CHECK(stops_off(match) == Approx(0).margin(0.2));
    }
  }
}

TEST_CASE("the code from which on the longer exposure is white is known where white begins, and only there") {
  const Response response = Response::gamma(2.2f);
  struct Scene {
    double dark, bright;  // stops: white in the long exposure from -5 on
    bool told;
  };
  for (const Scene& scene : {Scene{-10, 0, true}, {-7, -3, true}, {-12, -6, false}}) {
    const CodeMatches found = compared(
        0, [&](int, int x) { return std::exp2(scene.dark + (scene.bright - scene.dark) * x / 256); });
    CAPTURE(scene.dark, scene.bright);
    REQUIRE(found.white_from.size() == (scene.told ? 1 : 0));
    if (!scene.told) continue;
    const double stops = std::log2(response.exposure_of(1, found.white_from[0]) * kRatio);
    CHECK(stops > -0.02);
    CHECK(stops < 0.3);
  }
  const auto all_white = [](int, int x) { return std::exp2(-3 + 3. * x / 256); };
  CHECK_FALSE(
      HistogramMatches().add(recorded(1, 0, all_white), recorded(kRatio, 0, all_white), SceneCuts::None));
}

TEST_CASE("the darkest code of a shorter exposure is compared with a longer one's where both are dark") {
  struct Scene {
    double dark, bright;  // stops: code 24 in the short exposure is -7.5, code 127 in the long one -7.2
    bool told;
  };
  for (const Scene& scene : {Scene{-12, -4, true}, {-9, -4, true}, {-6, -1, false}, {-17, -10, false}}) {
    const CodeMatches found = compared(
        0, [&](int, int x) { return std::exp2(scene.dark + (scene.bright - scene.dark) * x / 256); });
    CAPTURE(scene.dark, scene.bright);
    REQUIRE(found.dark_to.size() == (scene.told ? 1 : 0));
    if (scene.told) CHECK(stops_off(found.dark_to[0]) > 0);  // a bound
  }
}
