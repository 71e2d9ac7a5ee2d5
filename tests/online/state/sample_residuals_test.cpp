#include "online/state/sample_residuals.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 48, kCols = 64;
constexpr float kRadiance = 0.05f;

// Samples of a flat picture that the state knows, at one exposure.
struct FlatSamples {
  RadianceState predicted{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols),
                          Image<float>(1, kRows, kCols)};
  Image<float> confidence{1, kRows, kCols};
  Samples samples;
  WorkerPool pool{2};
  SampleResiduals residuals;

  FlatSamples() {
    predicted.radiance.fill(kRadiance);
    predicted.variance.fill(1e-8f);
    confidence.fill(1);
    for (auto* image : {&samples.radiance, &samples.weight, &samples.comparable, &samples.blur})
      *image = Image<float>(3, kRows, kCols);
    samples.weight.fill(1);
  }
  // The tables then hold what was learned.
  void observe(const Response& response, const NoiseModel& noise, ExposureTables& tables) {
    residuals.observe({predicted, samples, tables, unseen_variance_from(4)}, confidence, pool);
    tables.rebuild(response, noise, residuals.excess(1));
  }
};

}  // namespace

TEST_CASE(
    "samples that are steadily off lose weight, at their exposure and brightness, until they are right") {
  constexpr float kOffset = 0.01f;
  const Response response = Response::gamma(2.2f);
  NoiseModel noise;
  noise.full_well = 1e6f, noise.code_noise = 0;
  FlatSamples flat;
  ExposureTables tables(response, noise, 1);
  const float at_first = tables.variance(0, kRadiance), elsewhere = tables.variance(0, 0.5f);
  const auto see = [&](float offset, int frames) {
    flat.samples.radiance.fill(kRadiance + offset);
    for (int i = 0; i < frames; ++i) flat.observe(response, noise, tables);
  };
  see(kOffset, 30);
  CHECK(tables.variance(0, kRadiance) == Approx(kOffset * kOffset).epsilon(0.2));
  CHECK(tables.variance(0, 0.5f) == elsewhere);
  CHECK(ExposureTables(response, noise, 16, flat.residuals.excess(16)).variance(0, kRadiance / 16) ==
        ExposureTables(response, noise, 16).variance(0, kRadiance / 16));
  see(0, 30);
  CHECK(tables.variance(0, kRadiance) == Approx(at_first).epsilon(0.05));
}

TEST_CASE("samples that scatter as their noise says lose no weight") {
  const Response response = Response::gamma(2.2f);
  const NoiseModel noise{.full_well = 1000, .read_noise = 0, .code_noise = 0};
  FlatSamples flat;
  ExposureTables tables(response, noise, 1);
  const float at_first = tables.variance(0, kRadiance);
  std::mt19937 random(9);
  std::normal_distribution<float> scatter(kRadiance, std::sqrt(at_first));
  for (int i = 0; i < 30; ++i) {
    for (float& sample : flat.samples.radiance.samples()) sample = scatter(random);
    flat.observe(response, noise, tables);
  }
  // a fortieth more: of each frame's 713 samples of a channel, where they happen to scatter more, that counts
  for (int c = 0; c < 3; ++c) CHECK(tables.variance(c, kRadiance) == Approx(at_first).epsilon(0.15));
}

TEST_CASE("samples are not off by the blur that the state expects of them") {
  constexpr float kBlur = 0.01f;
  const Response response = Response::gamma(2.2f);
  NoiseModel noise;
  noise.full_well = 1e6f, noise.code_noise = 0;
  FlatSamples flat;
  ExposureTables tables(response, noise, 1);
  const float at_first = tables.variance(0, kRadiance);
  flat.samples.radiance.fill(kRadiance + kBlur);
  flat.samples.blur.fill(kBlur);
  flat.samples.blurred = true;
  for (int i = 0; i < 10; ++i) flat.observe(response, noise, tables);
  CHECK(tables.variance(0, kRadiance) == at_first);
  flat.samples.blurred = false;
  flat.observe(response, noise, tables);
  CHECK(tables.variance(0, kRadiance) > 2 * at_first);
}
