#include "online/state/sample_residuals.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE(
    "samples that are steadily off lose weight, at their exposure and brightness, until they are right") {
  constexpr int kRows = 48, kCols = 64;
  constexpr float kRadiance = 0.05f, kOffset = 0.01f;
  const Response response = Response::gamma(2.2f);
  NoiseModel noise;
  noise.full_well = 1e6f, noise.code_noise = 0;
  RadianceState predicted{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                          Image<float>(1, kRows, kCols)};
  predicted.radiance.fill(kRadiance);
  predicted.variance.fill(1e-8f);
  Image<float> confidence(1, kRows, kCols);
  confidence.fill(1);
  Samples samples;
  for (auto* image : {&samples.radiance, &samples.weight, &samples.comparable})
    *image = Image<float>(3, kRows, kCols);
  samples.weight.fill(1);

  WorkerPool pool(2);
  SampleResiduals residuals;
  ExposureTables tables(response, noise, 1);
  const float at_first = tables.variance(0, kRadiance), elsewhere = tables.variance(0, 0.5f);
  const auto see = [&](float offset, int frames) {
    samples.radiance.fill(kRadiance + offset);
    for (int i = 0; i < frames; ++i) {
      residuals.observe({predicted, samples, tables, unseen_variance_from(4)}, confidence, pool);
      tables.rebuild(response, noise, residuals.excess(1));
    }
  };
  see(kOffset, 30);
  CHECK(tables.variance(0, kRadiance) == Approx(kOffset * kOffset).epsilon(0.2));
  CHECK(tables.variance(0, 0.5f) == elsewhere);
  CHECK(ExposureTables(response, noise, 16, residuals.excess(16)).variance(0, kRadiance / 16) ==
        ExposureTables(response, noise, 16).variance(0, kRadiance / 16));
  see(0, 30);
  CHECK(tables.variance(0, kRadiance) == Approx(at_first).epsilon(0.05));
}
