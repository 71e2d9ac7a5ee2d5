// Whether the light of the first frames is unsteady.
#include "online/response/first_light.h"

#include <array>
#include <cmath>
#include <vector>

#include "online/response/response_estimator.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr std::array<double, 6> kSteady{1, 1, 1, 1, 1, 1}, kLamps{1.25, 0.8, 1, 0.85, 1.2, 0.95},
    kDusk{1, 0.9, 0.81, 0.73, 0.66, 0.59};

std::vector<float> light_of(test::MovingScene scene, const std::array<double, 6>& light) {
  const double sensitivity = scene.sensitivity;
  std::vector<CompactFrame> frames;
  for (int i = 0; i < 6; ++i) {
    scene.sensitivity = sensitivity * light[static_cast<std::size_t>(i)];
    frames.emplace_back(test::exposed(scene.frame(i), i), 8);
  }
  return unsteady_light(frames, prior_mean_response());
}

}  // namespace

TEST_CASE(
    "lamps that flicker are seen in the first frames of each exposure, and how bright each of them is") {
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128;
  const std::vector<float> light = light_of(scene, kLamps);
  REQUIRE(light.size() == 6);
  for (std::size_t i = 0; i < 3; ++i) CHECK(light[i] + light[i + 3] == Approx(0).margin(1e-5));
  for (std::size_t i = 0; i < 2; ++i) {  // the third exposure's differ by little
    const double apart = std::log(kLamps[i + 3] / kLamps[i]);
    const double share = static_cast<double>(light[i + 3] - light[i]) / apart;
    CHECK(share > 0.5);  // the response that is assumed is another one
    CHECK(share < 1.2);
  }
}

TEST_CASE("steady light, and light that falls or rises all the time, is no light of lamps") {
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128;
  CHECK(light_of(scene, kSteady).empty());
  CHECK(light_of(scene, kDusk).empty());
  scene.drift_px = 6;
  CHECK(light_of(scene, kSteady).empty());
  scene.exposures_s = {0.001, 0.002, 0.004, 0.008, 0.016, 0.032};  // no two of a kind
  CHECK(light_of(scene, kLamps).empty());
}
