// Hard cases of the field, by name: whatever comes in, what is rendered is finite and the fit goes on.
#include "online/scene/hash_grid/field/field_renderer.h"
#include "tests/online/scene/hash_grid/fit/fit_stream.h"

#include <limits>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

struct Stream {
  WorkerPool pool{1};
  FitStream scene;
  FieldFit fit;
  FieldRenderer renderer;
  FieldPicture view;

  explicit Stream(const FieldOptions& options = FitStream::small_options())
      : fit(options, {}, scene.rows, scene.cols, pool) {
    fit.prepare(FitStream::small_budget());
  }

  // Lets `spoil` change each frame before it is observed; every picture must be fit to be emitted.
  template <class Spoil>
  void run(int frames, int steps, Spoil&& spoil) {
    for (int i = 0; i < frames; ++i) {
      FieldObservation seen = scene.frame(i);
      spoil(i, seen);
      REQUIRE(fit.observe(seen, scene.response).ok());
      for (int s = 0; s < steps; ++s) {
        const StepReport report = fit.step();
        REQUIRE(report.verdict == StepVerdict::Taken);  // nothing of a hard case reaches the loss
        REQUIRE(report.total < 100);                    // the loss does not explode
      }
      check(seen.time_s);
      const FieldNetworks<float>& networks = fit.field().networks;
      for (const Branch<float>* branch : {&networks.static_, &networks.dynamic}) {
        for (float p : branch->grid.tables().samples()) REQUIRE(std::isfinite(p));
        for (float p : branch->mlp.parameters()) REQUIRE(std::isfinite(p));
      }
    }
  }
  void check(double time_s) {
    renderer.render(fit.field(), FitStream::view(fit, {}, time_s, 2), pool, view);
    for (const Image<float>* plane :
         {&view.radiance, &view.depth, &view.flow[0], &view.flow[1], &view.confidence})
      for (float v : plane->samples()) REQUIRE(std::isfinite(v));
    for (float v : view.radiance.samples()) REQUIRE(v >= 0);
  }
  void uniform(float code, float radiance, float variance) {
    scene.codes.fill(code), scene.radiance.fill(radiance), scene.variance.fill(variance);
  }
};

}  // namespace

TEST_CASE("the field survives a stream that is all black", "[isa][stability]") {
  Stream stream;
  stream.run(8, 10, [&](int, FieldObservation&) { stream.uniform(0, 0, 1e-6f); });
  for (float v : stream.view.radiance.samples()) CHECK(v < 1e-3f);
}

TEST_CASE("the field survives a stream that is all saturated", "[isa][stability]") {
  Stream stream;
  stream.run(8, 10, [&](int, FieldObservation&) { stream.uniform(255, 4, kUnseenVariance); });
  for (float v : stream.view.radiance.samples()) CHECK(v >= 0.5f);
}

TEST_CASE("the field survives a single exposure and a constant colour", "[isa][stability]") {
  Stream stream;
  stream.scene.exposures = {1};
  stream.run(8, 10, [&](int, FieldObservation&) { stream.uniform(120, 0.19f, 1e-4f); });
  for (float v : stream.view.radiance.samples()) CHECK(v == Approx(0.19f).epsilon(0.1));
}

TEST_CASE("the field survives exposures ten stops apart", "[isa][stability]") {
  Stream stream;
  stream.scene.exposures = {1 / 32.f, 32.f};
  stream.run(8, 10, [](int, FieldObservation&) {});
}

TEST_CASE("the field survives one moving pixel", "[isa][stability]") {
  Stream stream;
  stream.run(8, 10, [&](int i, FieldObservation&) {
    stream.uniform(100, 0.1f, 1e-4f);
    stream.scene.to_previous.vectors.fill(0), stream.scene.from_previous.vectors.fill(0);
    for (int c = 0; c < 3; ++c)
      stream.scene.radiance.at(c, 10, 10 + i) = 50, stream.scene.codes.at(c, 10, 10 + i) = 255;
    stream.scene.to_previous.vectors.at(0, 10, 10 + i) = -1;
  });
}

TEST_CASE("the field survives poses without parallax", "[isa][stability]") {
  Stream stream;
  stream.run(10, 5, [](int i, FieldObservation& seen) {
    const double turn = 0.05 * i;  // rotation only
    seen.T_world_camera.R = rotation({0, turn, 0});
  });
  CHECK_FALSE(stream.fit.field().window.has_parallax());
}

TEST_CASE("a camera that turns right round does not break the field", "[isa][stability]") {
  Stream stream;
  stream.run(12, 3, [](int i, FieldObservation& seen) {
    const double turn = 0.6 * i;
    seen.T_world_camera = {rotation({0, turn, 0}), {0.3 * i, 0, 1.0 * i}};
  });
}

TEST_CASE("a view behind the scene or at the edge of time is finite", "[isa][stability]") {
  Stream stream;
  stream.run(5, 5, [](int, FieldObservation&) {});
  for (double time_s : {-100.0, 0.0, 1.5 / 30, 4.0 / 30, 4.49 / 30, 1e9}) {
    stream.check(time_s);
    stream.renderer.render(stream.fit.field(),
                           FitStream::view(stream.fit, {rotation({0, M_PI, 0}), {0, 0, -3}}, time_s, 4),
                           stream.pool, stream.view);
    for (float v : stream.view.radiance.samples()) REQUIRE((std::isfinite(v) && v >= 0));
  }
}

TEST_CASE("what is not a number never reaches the fit", "[isa][stability]") {
  Stream stream;
  const float bad = GENERATE(as<float>{}, kNan, kInf, -kInf, 1e38f, -5.f, 1e-42f);
  INFO("value " << bad);
  stream.run(6, 5, [&](int i, FieldObservation& seen) {
    Pcg32 random(static_cast<std::uint64_t>(i));
    const auto strew = [&](Image<float>& picture) {
      for (int k = 0; k < 40; ++k)
        picture.samples()[static_cast<std::size_t>(random.below(static_cast<int>(picture.size())))] = bad;
    };
    strew(stream.scene.codes), strew(stream.scene.radiance), strew(stream.scene.variance);
    strew(stream.scene.to_previous.vectors), strew(stream.scene.from_previous.confidence);
    seen.time_s = i == 2 ? static_cast<double>(bad) : seen.time_s;
    seen.blur_fraction = bad;
    if (i == 3) seen.T_world_camera.R(1, 1) = static_cast<double>(bad);
  });
  CHECK(stream.fit.counts().skipped == 0);
}

TEST_CASE("a depth prior that is partly wrong or not a number leaves the picture as it was",
          "[isa][stability]") {
  Stream stream;
  Image<float> depth(1, stream.scene.rows, stream.scene.cols);
  stream.run(6, 5, [&](int i, FieldObservation& seen) {
    const float values[] = {0.2f, kNan, kInf, -1.f, 7.f, 0.f};
    for (std::size_t p = 0; p < depth.size(); ++p) depth.samples()[p] = values[p % 6];
    seen.inverse_depth = &depth;
    seen.T_world_camera.t.x() = 0.02 * i;  // there is parallax, so that depth is looked for
  });
  CHECK(stream.fit.field().window.has_parallax());
  for (std::size_t p = 0; p < stream.view.depth.size(); ++p) REQUIRE(stream.view.depth.samples()[p] >= 1);
}

TEST_CASE("huge and tiny densities stay finite", "[isa][stability]") {
  const double bias = GENERATE(-1e4, -30.0, 30.0, 1e4);
  Pcg32 random(1);
  Composite<double> ray;
  ray.count = 5;
  double spacing[5] = {4, 4, 0, 4, 1}, d_weight[5] = {1, -2, 3, -4, 5}, d_share[5] = {1, 1, 1, 1, 1};
  for (int k = 0; k < 5; ++k)
    ray.density[0][k] = bounded_exp(bias, 12.0), ray.density[1][k] = bounded_exp(-bias, 12.0);
  composite_ray(spacing, ray);
  double sum = 0, d_density[2][kMaxSamples];
  for (int k = 0; k < 5; ++k) sum += ray.weight[k];
  CHECK(sum == Approx(1));
  composite_backward(spacing, ray, d_weight, d_share, d_density);
  for (int b = 0; b < 2; ++b)
    for (int k = 0; k < 5; ++k) CHECK(std::isfinite(d_density[b][k]));
}

TEST_CASE("a loss or gradient that is not finite is skipped, an exploding loss rolls back",
          "[isa][stability]") {
  FitHealth health;
  for (int i = 0; i < 30; ++i) REQUIRE(health.judge(1, 1) == StepVerdict::Taken);
  CHECK(health.judge(std::nan(""), 1) == StepVerdict::Skipped);
  CHECK(health.judge(1, std::numeric_limits<double>::infinity()) == StepVerdict::Skipped);
  CHECK(health.judge(1000, 1) == StepVerdict::RolledBack);
  CHECK_FALSE(health.is_lost());
  CHECK(health.judge(1, 100) == StepVerdict::Taken);
  CHECK(health.gradient_scale() == Approx(0.05));
  for (int i = 0; i < 3; ++i) health.judge(1e6, 1);
  CHECK(health.is_lost());
  CHECK(health.counts().skipped == 2);
  CHECK(health.counts().rolled_back == 4);
  CHECK(health.counts().clipped == 1);
}

TEST_CASE("two thousand frames leave the field where it was", "[isa][stability]") {
  Stream stream;
  double early = 0, late = 0;
  for (int i = 0; i < 2000; ++i) {
    const FieldObservation seen = stream.scene.frame(i);
    REQUIRE(stream.fit.observe(seen, stream.scene.response).ok());
    for (int s = 0; s < 2; ++s) {
      const double loss = stream.fit.step().total;
      REQUIRE(std::isfinite(loss));
      if (i >= 20 && i < 120) early += loss;
      if (i >= 1900) late += loss;
    }
  }
  stream.check(1999 / 30.0);
  INFO("loss " << early / 200 << " -> " << late / 200);
  CHECK(late < 1.5 * early);
  CHECK(stream.fit.counts().rolled_back == 0);
}
