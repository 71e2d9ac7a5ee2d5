#include <cmath>

#include "capture/unpack.h"
#include "online/priors/motion/state_motion.h"
#include "online/state/state_filter.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the drift of a scene is found between frames of different exposure, both ways") {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  scene.drift_px = 2.5, scene.disc_px = 2.5;
  WorkerPool pool(2);
  const Response response = Response::gamma(scene.gamma);
  UnpackSettings settings;
  settings.reference_exposure = 0.004;
  const auto before = unpack(scene.frame(1), 0, 1 / 30., settings).value();
  const auto after = unpack(scene.frame(2), 1, 1 / 30., settings).value();  // two stops longer
  StateFilter filter({}, scene.rows, scene.cols, pool);
  filter.fusion().set_white(4);
  filter.restart(before, ExposureTables(response, {}, before.exposure));
  MotionEstimator estimator(scene.rows, scene.cols, pool);
  StateMotion motion;
  const ExposureTables tables(response, {}, after.exposure);
  estimator.match(filter.state(), after, tables, FlowQuality::Medium, motion);
  estimator.complete(filter.state(), after, {}, FlowQuality::Medium, motion);
  double to = 0, from = 0, trusted = 0;
  int count = 0;
  for (int y = 20; y < 100; ++y)
    for (int x = 20; x < 140; ++x, ++count) {
      to += std::abs(static_cast<double>(motion.to_previous.vectors.at(0, y, x)) + 2.5);
      from += std::abs(static_cast<double>(motion.from_previous.vectors.at(0, y, x)) - 2.5);
      trusted += static_cast<double>(motion.to_previous.confidence.at(0, y, x));
    }
  CHECK(to / count < 0.35);
  CHECK(from / count < 0.35);
  CHECK(trusted / count > 0.8);
}

TEST_CASE("motion is the same for any number of threads, and zero for a picture too small to match") {
  test::MovingScene scene;
  for (const int rows : {8, 48}) {
    scene.rows = rows, scene.cols = rows + 5;
    std::vector<float> results[2];
    for (const int threads : {1, 3}) {
      WorkerPool pool(threads);
      UnpackSettings settings;
      settings.reference_exposure = 0.004;
      const auto a = unpack(scene.frame(0), 0, 1 / 30., settings).value();
      const auto b = unpack(scene.frame(1), 1, 1 / 30., settings).value();
      StateFilter filter({}, scene.rows, scene.cols, pool);
      filter.fusion().set_white(4);
      const Response response = Response::gamma(2.2f);
      filter.restart(a, ExposureTables(response, {}, a.exposure));
      MotionEstimator estimator(scene.rows, scene.cols, pool);
      StateMotion motion;
      estimator.match(filter.state(), b, ExposureTables(response, {}, b.exposure), FlowQuality::Medium,
                      motion);
      const auto samples = motion.to_previous.vectors.samples();
      results[threads == 1 ? 0 : 1].assign(samples.begin(), samples.end());
    }
    CHECK(results[0] == results[1]);
    if (rows == 8)
      for (const float v : results[0]) REQUIRE(v == 0);
  }
}
