// Every gradient of the fit against central differences, in double precision.
#include "online/scene/hash_grid/fit/losses/response_smoothness.h"
#include "online/scene/hash_grid/fit/ray_shard.h"
#include "tests/online/scene/hash_grid/fit/window_fixture.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRays = 24, kSamples = 6;

FieldShape small_shape(Blend blend) {
  FieldShape shape;
  shape.static_grid = {4, 8, 1, 4, 16, 0.75f, 0.5f};
  shape.dynamic_grid = {2, 8, 4, 4, 12, 0.75f, 0.5f};
  shape.hidden = 8;
  shape.blend = blend;
  return shape;
}

// The whole objective of one shard as a function of every parameter of the field.
struct Bench {
  WindowFixture scene{24, 32, 3, true};
  Pcg32 random{3};
  FieldNetworks<double> networks;
  LearnedResponse<double> response{scene.response};
  LossWeights weights{};
  std::vector<TrainingRay> rays = scene.rays(kRays);
  RayShard<double> shard;
  bool has_dynamic = true;

  explicit Bench(Blend blend = Blend::DensitySum)
      : networks(small_shape(blend), random), shard(networks, kRays, kSamples) {
    // away from the start, where residuals are nearly zero, many gradients vanish, and a unit whose inputs
    // are all off sits exactly on the kink of its rectifier
    for (auto* branch : {&networks.static_, &networks.dynamic}) {
      for (double& value : branch->grid.tables().samples()) value *= 60;
      for (double& value : branch->mlp.parameters())
        value = 2 * value + static_cast<double>(random.uniform(-0.1f, 0.1f));
    }
  }

  double loss() {
    const StepSetting<double> step{.networks = networks,
                                   .window = scene.window,
                                   .response = response,
                                   .weights = weights,
                                   .samples_per_ray = kSamples,
                                   .has_dynamic = has_dynamic,
                                   .fits_response = true,
                                   .ray_share = 1.0 / kRays};
    shard.run(step, rays, Pcg32(9));
    double sum = 0;
    for (double value : shard.losses()) sum += value;
    return sum;
  }

  void gradients() {
    for (auto* branch : {&networks.static_, &networks.dynamic}) branch->grid.reserve_gradient();
    loss();
    for (int l = 0; l < networks.static_.grid.shape().levels; ++l)
      shard.scatter_static(l, networks.static_.grid);
    for (int l = 0; l < networks.dynamic.grid.shape().levels; ++l)
      shard.scatter_dynamic(l, networks.dynamic.grid);
  }

  // Along the gradient and along two random directions.
  void check(std::span<double> parameters, std::span<const double> gradient) {
    const std::vector<double> start(parameters.begin(), parameters.end()),
        slope(gradient.begin(), gradient.end());
    Pcg32 chance(21);
    for (int trial = 0; trial < 3; ++trial) {
      std::vector<double> direction = slope;
      if (trial > 0)
        for (double& d : direction) d = static_cast<double>(chance.uniform(-1, 1));
      double norm = 0, expected = 0;
      for (double d : direction) norm += d * d;
      norm = std::sqrt(norm);
      if (norm == 0) continue;
      for (std::size_t i = 0; i < direction.size(); ++i) expected += slope[i] * direction[i] / norm;
      const double step = 1e-6;
      double side[2];
      for (int k = 0; k < 2; ++k) {
        for (std::size_t i = 0; i < start.size(); ++i)
          parameters[i] = start[i] + (k == 0 ? step : -step) * direction[i] / norm;
        side[k] = loss();
      }
      std::copy(start.begin(), start.end(), parameters.begin());
      const double measured = (side[0] - side[1]) / (2 * step);
      INFO("direction " << trial << ": gradient " << expected << ", difference " << measured);
      CHECK(measured == Approx(expected).epsilon(1e-4).margin(1e-7));
    }
  }

  void check_all() {
    gradients();
    const std::vector<double> d_static(shard.d_static().begin(), shard.d_static().end());
    const std::vector<double> d_dynamic(shard.d_dynamic().begin(), shard.d_dynamic().end());
    SECTION("static network") { check(networks.static_.mlp.parameters(), d_static); }
    SECTION("dynamic network") { check(networks.dynamic.mlp.parameters(), d_dynamic); }
    SECTION("static tables") {
      for (int l = 0; l < networks.static_.grid.shape().levels; ++l)
        check(networks.static_.grid.table(l), networks.static_.grid.d_table(l));
    }
    SECTION("dynamic tables") {
      for (int l = 0; l < networks.dynamic.grid.shape().levels; ++l)
        check(networks.dynamic.grid.table(l), networks.dynamic.grid.d_table(l));
    }
  }
};

double norm(std::span<const double> values) {
  double sum = 0;
  for (double v : values) sum += v * v;
  return std::sqrt(sum);
}

}  // namespace

TEST_CASE("each loss term has the gradient that finite differences find", "[isa][field][gradient]") {
  const auto term = GENERATE(LossTerm::Combined, LossTerm::Warped, LossTerm::Occlusion, LossTerm::Flow,
                             LossTerm::Depth, LossTerm::Cycle, LossTerm::SpatialSmoothness,
                             LossTerm::TemporalSmoothness, LossTerm::MinimalFlow, LossTerm::State,
                             LossTerm::Consistency, LossTerm::BlendEntropy, LossTerm::Distortion);
  Bench bench;
  bench.weights[static_cast<std::size_t>(term)] = 1;
  INFO("loss term " << kLosses[static_cast<std::size_t>(term)].name);
  bench.gradients();
  // a gradient that is zero everywhere would agree with a loss that does nothing
  CHECK(norm(bench.shard.d_dynamic()) > 1e-6);
  bench.check_all();
}

TEST_CASE("the whole objective has the right gradient", "[isa][field][gradient]") {
  SECTION("blended by density") {
    Bench bench;
    bench.weights = default_loss_weights();
    bench.weights[static_cast<std::size_t>(LossTerm::Depth)] = 0.04f;
    bench.check_all();
  }
  SECTION("blended by the paper's weight") {
    Bench bench(Blend::Weight);
    bench.weights = default_loss_weights();
    bench.check_all();
  }
  SECTION("without a dynamic branch") {
    Bench bench;
    bench.weights = default_loss_weights();
    bench.has_dynamic = false;
    bench.check_all();
  }
}

TEST_CASE("the response has the gradient that finite differences find", "[isa][field][gradient]") {
  Bench bench;
  bench.weights[static_cast<std::size_t>(LossTerm::Combined)] = 1;
  const float smoothness = 0.01f;
  const auto loss = [&] {
    LearnedResponse<double>::Gradient ignored{};
    return bench.loss() + response_smoothness_loss(static_cast<double>(smoothness), bench.response, ignored);
  };
  loss();
  auto d_point = bench.shard.d_response();
  response_smoothness_loss(static_cast<double>(smoothness), bench.response, d_point);
  std::array<std::array<double, LearnedResponse<double>::kSegments>, 3> d_increment{};
  bench.response.backward(d_point, d_increment);
  Pcg32 chance(2);
  for (int trial = 0; trial < 12; ++trial) {
    const auto c = static_cast<std::size_t>(chance.below(3)), j = static_cast<std::size_t>(chance.below(255));
    double& increment = bench.response.increments()[c][j];
    const double start = increment, step = 1e-5;
    increment = start + step, bench.response.rebuild();
    const double above = loss();
    increment = start - step, bench.response.rebuild();
    const double below = loss();
    increment = start, bench.response.rebuild();
    INFO("channel " << c << " increment " << j);
    CHECK((above - below) / (2 * step) == Approx(d_increment[c][j]).epsilon(1e-4).margin(1e-9));
  }
}
