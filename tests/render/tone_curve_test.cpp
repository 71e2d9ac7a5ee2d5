#include "render/tone_curve.h"

#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// Log-normal luminance of a spread of a few stops around `mid`, as outdoor scenes have it.
Image<float> natural(float mid, unsigned seed) {
  Image<float> radiance(3, 48, 64);
  std::mt19937 random(seed);
  std::normal_distribution<float> stops(0, 2);
  for (float& value : radiance.samples()) value = mid * std::exp2(stops(random));
  return radiance;
}

}  // namespace

TEST_CASE("the tone curve rises monotonically from black to white over all radiance") {
  for (const ToneAnchors anchors : {ToneAnchors{0.18f, 1}, ToneAnchors{0.001f, 50}, ToneAnchors{300, 1e5f}}) {
    const ToneCurve curve(anchors);
    CHECK(curve.code(0) == 0);
    int before = 0;
    for (float radiance = 1e-8f; radiance <= 1e6f; radiance *= 1.003f) {
      const int code = curve.code(radiance);
      REQUIRE(code >= before);
      REQUIRE(code - before <=
              2);  // no visible step: a third of a percent of radiance is never more than two codes
      before = code;
    }
    CHECK(curve.code(anchors.white) == 255);
    CHECK(curve.code(1e6f) == 255);
  }
}

TEST_CASE("the middle of the scene is shown as a mid grey") {
  CHECK(ToneCurve({0.05f, 5}).code(0.05f) == 124);
  CHECK(ToneCurve({80, 8000}).code(80) == 124);
}

TEST_CASE("what is no positive number has a code, too") {
  const ToneCurve curve(ToneAnchors{});
  CHECK(curve.code(-1) == 0);
  CHECK(curve.code(std::numeric_limits<float>::quiet_NaN()) == 0);
  CHECK(curve.code(std::numeric_limits<float>::denorm_min()) == 0);
  CHECK(curve.code(-std::numeric_limits<float>::infinity()) == 0);
  CHECK(curve.code(std::numeric_limits<float>::infinity()) == 255);
  CHECK(curve.code(std::numeric_limits<float>::max()) == 255);
}

TEST_CASE("anchors scale with the picture") {
  const auto once = tone_anchors(natural(0.1f, 7));
  const auto eightfold = tone_anchors(natural(0.8f, 7));
  REQUIRE(once);
  REQUIRE(eightfold);
  CHECK(eightfold->mid == Approx(8 * once->mid).epsilon(1e-4));
  CHECK(eightfold->white == Approx(8 * once->white).epsilon(1e-4));
  CHECK(once->white >= 4 * once->mid);
}

TEST_CASE("pixels that are not numbers do not move the anchors") {
  const auto clean = tone_anchors(natural(0.1f, 7));
  auto radiance = natural(0.1f, 7);
  for (int x = 0; x < radiance.cols(); x += 3) {
    radiance.at(1, 0, x) = std::numeric_limits<float>::quiet_NaN();
    radiance.at(1, 3, x) = std::numeric_limits<float>::infinity();
  }
  const auto dirty = tone_anchors(radiance);
  REQUIRE(dirty);
  CHECK(dirty->mid == Approx(clean->mid).epsilon(0.1));
}

TEST_CASE("a black picture has no anchors, and the curve waits for the first light") {
  const Image<float> black(3, 16, 16);
  CHECK_FALSE(tone_anchors(black).has_value());
  ToneAdaptation adaptation;
  adaptation.follow(black);
  const auto lit = natural(40, 3);
  CHECK(adaptation.follow(lit).anchors().mid == tone_anchors(lit)->mid);
}

TEST_CASE("the curve follows a brighter scene by at most a hundredth of a stop a frame") {
  ToneAdaptation adaptation;
  float before = adaptation.follow(natural(0.1f, 5)).anchors().mid;
  const auto brighter = natural(1.6f, 5);
  for (int frame = 0; frame < 500; ++frame) {
    const float mid = adaptation.follow(brighter).anchors().mid;
    REQUIRE(std::abs(std::log2(mid / before)) <= ToneAdaptation::kMaxStep * 1.001f);
    before = mid;
  }
  CHECK(before == Approx(tone_anchors(brighter)->mid).epsilon(1e-3));
}

TEST_CASE("a still scene is shown with the same codes in every frame") {
  const auto scene = natural(0.3f, 9);
  ToneAdaptation adaptation;
  const auto first = tone_mapped(scene, adaptation.follow(scene));
  for (int frame = 0; frame < 20; ++frame) {
    const auto next = tone_mapped(scene, adaptation.follow(scene));
    REQUIRE(std::equal(first.samples().begin(), first.samples().end(), next.samples().begin()));
  }
}
