// The gradients of a step on the graphics device against the processor's in double precision.
#include "online/scene/hash_grid/fit/vulkan/vulkan_fit.h"

#include <cmath>
#include <memory>

#include "online/scene/hash_grid/fit/ray_shard.h"
#include "tests/online/scene/hash_grid/field/learned_networks.h"
#include "tests/online/scene/hash_grid/fit/window_fixture.h"

#include "tests/support/checked_gpu.h"

using namespace hdrcam;

namespace {

constexpr int kRays = 64, kFrames = 3;
constexpr std::uint64_t kSeed = 9, kStream = 40;

// A window, and a field far from its start.
struct Bench {
  WindowFixture scene{24, 33, kFrames, true};
  FieldNetworks<float> networks;
  OptimisedBranches branches{networks};
  LearnedResponse<float> response{scene.response};
  LossWeights weights = default_loss_weights();
  int samples = 6;
  bool has_dynamic = true;
  std::vector<TrainingRay> rays = scene.rays(kRays);
  WorkerPool pool{1};
  StepSums sums;
  std::unique_ptr<VulkanFit> there;

  explicit Bench(GpuDevice& gpu, Blend blend = Blend::DensitySum)
      : networks(learned_networks(blend, kFrames)) {
    // rays() may look for a neighbour beyond the last frame
    for (TrainingRay& ray : rays)
      if (const int n = neighbour_of(ray); n < 0 || n >= kFrames) ray.warps = false;
    there = value_of(VulkanFit::make(gpu, networks));
  }
  template <class T>
  StepSetting<T> setting(const FieldNetworks<T>& of, const LearnedResponse<T>& curve) const {
    return {.networks = of,
            .window = scene.window,
            .response = curve,
            .weights = weights,
            .samples_per_ray = samples,
            .has_dynamic = has_dynamic,
            .fits_response = true,
            .ray_share = T(1) / T(kRays)};
  }

  Result<void> begin() { return there->begin(scene.window, branches, {kRays, samples, has_dynamic}); }
  Result<void> gradients() {
    return there->gradients(setting(networks, response), rays, {kSeed, kStream}, pool, branches, sums);
  }
  // The tables' gradient, as Adam's mean once its past counts for nothing.
  void collect_gradients() {
    const AdamStep nothing_else{0, 1, 0, 0, 1};
    there->take(nothing_else, nothing_else);
    require_done(there->collect(branches));
  }
};

// The same in double precision.
struct Truth {
  Pcg32 random{1};
  FieldNetworks<double> networks;
  LossValues<double> losses{};
  LearnedResponse<double>::Gradient d_response{};
  std::vector<double> d_static, d_dynamic;
  double feature_energy = 0;
  std::vector<float> misfits;

  explicit Truth(const Bench& bench) : networks(learned_shape(bench.networks.blend, kFrames), random) {
    for (auto [to, from] : {std::pair(&networks.static_, &bench.networks.static_),
                            {&networks.dynamic, &bench.networks.dynamic}}) {
      std::copy(from->grid.tables().samples().begin(), from->grid.tables().samples().end(),
                to->grid.tables().samples().begin());
      std::copy(from->mlp.parameters().begin(), from->mlp.parameters().end(), to->mlp.parameters().begin());
      to->grid.reserve_gradient();
    }
    const LearnedResponse<double> response(bench.scene.response);
    const StepSetting<double> step = bench.setting(networks, response);
    d_static.resize(networks.static_.mlp.parameters().size());
    d_dynamic.resize(networks.dynamic.mlp.parameters().size());
    RayShard<double> shard(networks, kRaysPerShard, kMaxSamples);
    for (std::size_t i = 0; i < kRays / kRaysPerShard; ++i) {
      shard.run(step, std::span(bench.rays).subspan(i * kRaysPerShard, kRaysPerShard),
                Pcg32(kSeed, kStream + i));
      for (std::size_t k = 0; k < losses.size(); ++k) losses[k] += shard.losses()[k];
      for (std::size_t k = 0; k < d_static.size(); ++k) d_static[k] += shard.d_static()[k];
      for (std::size_t k = 0; k < d_dynamic.size(); ++k) d_dynamic[k] += shard.d_dynamic()[k];
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < d_response[c].size(); ++k) d_response[c][k] += shard.d_response()[c][k];
      feature_energy += shard.feature_energy();
      misfits.insert(misfits.end(), shard.misfits().begin(), shard.misfits().end());
      for (int l = 0; l < networks.static_.grid.shape().levels; ++l)
        shard.scatter_static(l, networks.static_.grid);
      if (!bench.has_dynamic) continue;
      for (int l = 0; l < networks.dynamic.grid.shape().levels; ++l)
        shard.scatter_dynamic(l, networks.dynamic.grid);
    }
  }
};

double norm(std::span<const double> values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum);
}

// As vectors: the difference against the length of the gradient.
void check_alike(std::span<const float> there, std::span<const double> truth, const char* what,
                 double tolerance = 2e-4) {
  REQUIRE(there.size() == truth.size());
  double apart = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    REQUIRE(std::isfinite(there[i]));
    const double d = static_cast<double>(there[i]) - truth[i];
    apart += d * d;
  }
  INFO(what << ": length " << norm(truth) << ", apart " << std::sqrt(apart));
  CHECK(std::sqrt(apart) <= tolerance * norm(truth) + 1e-12);
}

std::vector<double> table_gradient(HashGrid<double>& grid) {
  std::vector<double> all;
  for (int l = 0; l < grid.shape().levels; ++l) {
    const std::span<double> level = grid.d_table(l);
    all.insert(all.end(), level.begin(), level.end());
  }
  return all;
}

void compare(Bench& bench) {
  require_done(bench.begin());
  require_done(bench.gradients());
  Truth truth(bench);
  for (std::size_t k = 0; k < kLossTerms; ++k) {
    INFO("loss " << kLosses[k].name);
    CHECK(bench.sums.losses[k] == Approx(truth.losses[k]).epsilon(1e-3).margin(1e-6));
  }
  for (std::size_t r = 0; r < kRays; ++r)
    CHECK(bench.sums.misfits[r] == Approx(truth.misfits[r]).epsilon(2e-3).margin(1e-5));
  CHECK(bench.sums.feature_energy == Approx(truth.feature_energy).epsilon(2e-3));
  for (std::size_t c = 0; c < 3; ++c) check_alike(bench.sums.d_response[c], truth.d_response[c], "response");
  check_alike(bench.branches.static_.d_network, truth.d_static, "static network");
  check_alike(bench.branches.dynamic.d_network, truth.d_dynamic, "dynamic network");
  bench.collect_gradients();
  check_alike(bench.branches.static_.table_mean.samples(), table_gradient(truth.networks.static_.grid),
              "static tables");
  check_alike(bench.branches.dynamic.table_mean.samples(), table_gradient(truth.networks.dynamic.grid),
              "dynamic tables");
}

}  // namespace

TEST_CASE("each loss term has the gradient on the graphics device that it has in double precision", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  for (const auto term :
       {LossTerm::Combined, LossTerm::Warped, LossTerm::Occlusion, LossTerm::Flow, LossTerm::Depth,
        LossTerm::Cycle, LossTerm::SpatialSmoothness, LossTerm::TemporalSmoothness, LossTerm::MinimalFlow,
        LossTerm::State, LossTerm::Consistency, LossTerm::BlendEntropy, LossTerm::Distortion}) {
    INFO("loss term " << kLosses[static_cast<std::size_t>(term)].name);
    Bench bench(*gpu);
    bench.weights.fill(0);
    bench.weights[static_cast<std::size_t>(term)] = 1;
    compare(bench);
  }
}

TEST_CASE("the whole objective has its gradient on the graphics device, whatever the samples and the blend",
          "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  for (const Blend blend : {Blend::DensitySum, Blend::Weight})
    for (const int samples : {1, 2, 8, 16})
      for (const bool has_dynamic : {true, false}) {
        INFO(samples << " samples, dynamic " << has_dynamic << ", blend " << static_cast<int>(blend));
        Bench bench(*gpu, blend);
        bench.samples = samples, bench.has_dynamic = has_dynamic;
        bench.weights[static_cast<std::size_t>(LossTerm::Depth)] = 0.04f;
        compare(bench);
      }
}
