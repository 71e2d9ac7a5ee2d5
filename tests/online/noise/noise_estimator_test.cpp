#include "online/noise/noise_estimator.h"

#include "capture/unpack.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("shot noise is measured from a still scene, and nothing is claimed from too little") {
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128;
  scene.drift_px = scene.disc_px = 0;
  scene.detail = 0.2;
  WorkerPool pool(2);
  const Response response = Response::gamma(scene.gamma);
  FlowField still{Image<float>(2, scene.rows, scene.cols), Image<float>(1, scene.rows, scene.cols)};
  still.confidence.fill(1);
  UnpackSettings settings;
  settings.reference_exposure = 0.004;
  std::vector<float> found;
  for (const double full_well : {700., 2500.}) {
    scene.full_well = full_well;
    NoiseEstimator estimator(pool);
    NoiseModel guess;
    CHECK(estimator.solve(guess).full_well == guess.full_well);
    for (int i = 0; i + 1 < 9; ++i) {
      const auto a = unpack(scene.frame(i), i, 1 / 30., settings).value();
      const auto b = unpack(scene.frame(i + 1), i + 1, 1 / 30., settings).value();
      if (a.exposure <= b.exposure)
        estimator.add_pair(a, b, still, response);
      else
        estimator.add_pair(b, a, still, response);
    }
    found.push_back(estimator.solve(guess).full_well);
  }
  INFO("found " << found[0] << " and " << found[1] << " electrons");
  // interpolation is assumed to halve the noise of one frame; a still scene is not interpolated: up to 1.5
  // times too much
  CHECK(found[0] > 350);
  CHECK(found[0] < 1050);
  // with a deeper well the step of eight bits hides the shot noise: only the order is certain
  CHECK(found[1] > 2 * found[0]);
}
