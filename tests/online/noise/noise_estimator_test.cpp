#include "online/noise/noise_estimator.h"

#include <cmath>
#include <optional>

#include "tests/support/coded_frame.h"
#include "tests/support/moving_scene.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// What the estimator finds in nine frames of a still scene.
NoiseModel found_in(const test::MovingScene& scene, const Response& response,
                    const std::optional<NoiseModel>& seen = std::nullopt) {
  WorkerPool pool(2);
  const FlowField still = test::uniform_flow(scene.rows, scene.cols);
  NoiseEstimator estimator(pool);
  if (seen) estimator.expect(*seen);
  for (int i = 0; i + 1 < 9; ++i) {
    const auto a = test::exposed(scene.frame(i), i);
    const auto b = test::exposed(scene.frame(i + 1), i + 1);
    if (a.exposure <= b.exposure)
      estimator.add_pair(a, b, still, response);
    else
      estimator.add_pair(b, a, still, response);
  }
  NoiseModel assumed;
  assumed.code_noise = 0.3f;
  return estimator.solve(assumed);
}

test::MovingScene still_scene() {
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128;
  scene.drift_px = scene.disc_px = 0;
  scene.detail = 0.2;
  return scene;
}

}  // namespace

TEST_CASE(
    "full well and read noise are found within a factor of two, and nothing is claimed from too little") {
  WorkerPool pool(1);
  CHECK(NoiseEstimator(pool).solve(NoiseModel{}).full_well == NoiseModel{}.full_well);
  struct Sensor {
    double full_well, read_noise;
  };
  for (const Sensor sensor : {Sensor{1000, 10}, Sensor{2500, 6}, Sensor{8000, 5}}) {
    test::MovingScene scene = still_scene();
    scene.full_well = sensor.full_well, scene.read_noise = sensor.read_noise;
    const NoiseModel found = found_in(scene, Response::gamma(scene.gamma));
    INFO("found " << found.full_well << " / " << found.read_noise << " electrons, codes " << found.code_noise
                  << ", of " << sensor.full_well << " / " << sensor.read_noise);
    CHECK(found.full_well > 0.5 * sensor.full_well);
    CHECK(found.full_well < 2 * sensor.full_well);
    CHECK(found.read_noise > 0.5 * sensor.read_noise);
    CHECK(found.read_noise < 2 * sensor.read_noise);
  }
}

TEST_CASE("an error of the response is not taken for noise") {
  test::MovingScene scene = still_scene();
  scene.full_well = 2500;
  const NoiseModel right = found_in(scene, Response::gamma(scene.gamma));
  const NoiseModel wrong = found_in(scene, Response::gamma(scene.gamma - 0.2f));
  INFO("full well " << right.full_well << " with the right response, " << wrong.full_well
                    << " with a wrong one");
  CHECK(wrong.full_well > 0.6f * right.full_well);
  CHECK(wrong.full_well < 1.7f * right.full_well);
}

TEST_CASE("what single frames show of the noise is the start, and pairs correct it") {
  test::MovingScene scene = still_scene();
  scene.full_well = 8000, scene.read_noise = 20;  // more than usual: a usual prior finds less
  NoiseModel seen;
  seen.full_well = 7000, seen.read_noise = 22, seen.code_noise = 0.1f;
  const Response response = Response::gamma(scene.gamma);
  const NoiseModel alone = found_in(scene, response), after = found_in(scene, response, seen);
  INFO("read noise " << alone.read_noise << " alone, " << after.read_noise << " after 22 was seen, of 20");
  CHECK(std::abs(after.read_noise - 20) < 0.5f * std::abs(alone.read_noise - 20));
  CHECK(after.read_noise == Approx(20).epsilon(0.12));
  CHECK(after.full_well == Approx(8000).epsilon(0.2));
}

TEST_CASE("after a change of gain the noise is that of the new frames, as soon as they fill the bins") {
  constexpr float kFullWell = 1000, kReadNoise = 4, kGain = 16;  // electrons at the gain of the first frames
  constexpr int kRows = 64, kStrips = 14, kStripCols = 16;       // half a stop apart
  const Response response = Response::gamma(2.2f);
  const FlowField still = test::uniform_flow(kRows, kStrips * kStripCols);
  WorkerPool pool(2);
  std::uint64_t key = 0;
  int index = 0;
  const auto frame_at = [&](float gain) {
    const NoiseModel noise{.full_well = kFullWell / gain, .read_noise = kReadNoise};
    ExposedFrame frame = test::coded_frame(kRows, kStrips * kStripCols, [&](int c, int, int x) {
      const float light = 0.7f * std::exp2(-0.5f * static_cast<float>(x / kStripCols));
      const auto grain = static_cast<float>(test::MovingScene::noise(++key));
      const float seen = light + grain * std::sqrt(noise.exposure_variance(light));
      return std::round(response.code_of(c, std::clamp(seen, 0.f, 1.f)));
    });
    frame.index = index++;
    return frame;
  };
  NoiseEstimator estimator(pool);
  const auto full_well_after = [&](int pairs, float gain) {
    ExposedFrame a = frame_at(gain);
    for (int i = 0; i < pairs; ++i) {
      ExposedFrame b = frame_at(gain);
      estimator.add_pair(a, b, still, response, {gain, gain});
      a = std::move(b);
    }
    return estimator.solve(NoiseModel{.code_noise = 0.05f}).full_well;
  };
  constexpr int kUntilFull = 30;  // pairs
  CHECK(full_well_after(kUntilFull, 1) == Approx(kFullWell).epsilon(0.25));
  CHECK(full_well_after(kUntilFull, 1 / kGain) == Approx(kFullWell).epsilon(0.25));
  CHECK(full_well_after(kUntilFull, 1) == Approx(kFullWell).epsilon(0.25));
}
