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
    // interpolation is assumed to halve the noise of one frame; a still scene is not interpolated: up to 1.5 times too much
    INFO("full well " << full_well);
    const float found = estimator.solve(guess).full_well;
    CHECK(found > full_well / 2);
    CHECK(found < full_well * 1.5);
  }
}
