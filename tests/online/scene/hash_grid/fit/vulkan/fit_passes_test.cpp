// Each kernel of the fit against its readable twin, in double precision where the twin has it.
#include "online/scene/hash_grid/fit/vulkan/fit_passes.h"

#include <bit>
#include <cmath>
#include <optional>

#include "online/scene/hash_grid/field/vulkan/branch_layout.h"
#include "tests/online/scene/hash_grid/fit/window_fixture.h"

#include "tests/support/checked_gpu.h"

using namespace hdrcam;

namespace {

constexpr int kRays = 32, kSamples = 6, kCount = kRays * kSamples, kRow = 2 * kCount;

// Buffers of a step whose samples lie anywhere, at the edges of the cube and beyond.
struct Bench {
  std::unique_ptr<GpuDevice> gpu;
  WindowFixture scene{12, 16, 3, true};
  Pcg32 random{3};
  FieldNetworks<float> networks;
  OptimisedBranch static_branch{networks.static_}, dynamic_branch{networks.dynamic};
  LearnedResponse<float> response{scene.response};
  LossWeights weights{};
  std::optional<FitPasses> passes;
  GpuBranch static_gpu, dynamic_gpu;
  GpuRays rays;
  Image<float> position{4, 1, kRow};  // and slot
  std::vector<std::int32_t> slot = std::vector<std::int32_t>(kRow, 0);

  static FieldShape shape() {
    FieldShape shape;
    shape.static_grid = {4, 8, 1, 4, 24, 0.75f, 0.5f};
    shape.dynamic_grid = {2, 7, 4, 4, 12, 0.75f, 0.5f};
    shape.hidden = 12;
    return shape;
  }
  explicit Bench(std::unique_ptr<GpuDevice> device) : gpu(std::move(device)), networks(shape(), random) {
    if (gpu == nullptr) return;
    for (auto* branch : {&networks.static_, &networks.dynamic}) {
      for (float& value : branch->grid.tables().samples()) value = random.uniform(-1, 1);
      for (float& value : branch->mlp.parameters()) value = random.uniform(-0.5f, 0.5f);
    }
    for (OptimisedBranch* part : {&static_branch, &dynamic_branch}) {
      for (float& v : part->table_mean.samples()) v = random.uniform(-0.1f, 0.1f);
      for (float& v : part->table_variance.samples()) v = random.uniform(0.1f, 0.2f);
      for (float& v : part->network.mean) v = random.uniform(-0.1f, 0.1f);
      for (float& v : part->network.variance) v = random.uniform(0.1f, 0.2f);
    }
    passes = value_of(FitPasses::make(*gpu));
    static_gpu = value_of(GpuBranch::make(*gpu, networks.static_, 0));
    dynamic_gpu = value_of(GpuBranch::make(*gpu, networks.dynamic, branch_constants::kStaticOutputs));
    require_done(static_gpu.reserve(*gpu, kRow));
    require_done(dynamic_gpu.reserve(*gpu, kRow));
    require_done(rays.reserve(*gpu, scene.window, kRays, kSamples));
    rays.begin({.networks = networks,
                .window = scene.window,
                .response = response,
                .weights = weights,
                .samples_per_ray = kSamples,
                .has_dynamic = true,
                .fits_response = false,
                .ray_share = 1.f / kRays},
               kRays);
    static_gpu.upload(work(), static_branch);
    dynamic_gpu.upload(work(), dynamic_branch);
    const float edges[] = {0, 1, 0.25f, 0.9999999f, -1e30f, 1e30f};
    for (int s = 0; s < kRow; ++s) {
      for (int axis = 0; axis < 3; ++axis)
        position.plane(axis)[s] = s < 6 ? edges[s] : random.uniform(-0.1f, 1.1f);
      slot[static_cast<std::size_t>(s)] = random.below(4);
      position.plane(3)[s] = static_cast<float>(slot[static_cast<std::size_t>(s)]);
    }
    put(position, rays.placed);
    require_done(work().finish());
  }
  GpuWork& work() { return gpu->work(); }
  void put(const Image<float>& values, const GpuRoom& to) {
    work().upload(std::as_bytes(values.samples()), **to);
  }
  Image<float> rows(int planes, float low, float high) {
    Image<float> values(planes, 1, kRow);
    for (float& v : values.samples()) v = random.uniform(low, high);
    return values;
  }
  Image<float> get(const GpuRoom& from, int planes, int cols = kRow) {
    Image<float> values(planes, 1, cols);
    work().download(**from, std::as_writable_bytes(values.samples()));
    require_done(work().finish());
    return values;
  }
  GridSamples<float> samples(int count) const { return {position, slot, count}; }
  // Both branches' parameters as they are there.
  void collect() {
    GpuBranch::Arrival of_static, of_dynamic;
    static_gpu.download(work(), static_branch, of_static);
    dynamic_gpu.download(work(), dynamic_branch, of_dynamic);
    require_done(work().finish());
    GpuBranch::take(of_static, static_branch);
    GpuBranch::take(of_dynamic, dynamic_branch);
  }
  // The gradient that scatter() has left in the dynamic branch's tables: Adam's mean once its past counts for
  // nothing.
  std::vector<float> table_gradient(int count) {
    dynamic_branch.table_mean.fill(0);
    work().clear(**dynamic_gpu.table_mean);
    const AdamStep nothing_else{0, 1, 0, 0, 1};
    passes->adam(dynamic_gpu, nothing_else, nothing_else, count);
    collect();
    return {dynamic_branch.table_mean.samples().begin(), dynamic_branch.table_mean.samples().end()};
  }
};

void check_alike(std::span<const float> there, std::span<const float> here, float tolerance) {
  REQUIRE(there.size() == here.size());
  for (std::size_t i = 0; i < here.size(); ++i) {
    INFO("value " << i);
    REQUIRE(there[i] == Approx(here[i]).epsilon(tolerance).margin(tolerance));
  }
}

Mlp<double> doubled(const Mlp<float>& mlp) {
  Pcg32 random(1);
  Mlp<double> copy(mlp.inputs(), mlp.hidden(), mlp.outputs(), 1, random);
  std::copy(mlp.parameters().begin(), mlp.parameters().end(), copy.parameters().begin());
  return copy;
}
Image<double> doubled(const Image<float>& values) {
  Image<double> copy(values.channels(), values.rows(), values.cols());
  std::copy(values.samples().begin(), values.samples().end(), copy.samples().begin());
  return copy;
}
std::vector<float> rounded(std::span<const double> values) { return {values.begin(), values.end()}; }

}  // namespace

TEST_CASE("hash grids on the graphics device encode each sample in its own slot", "[gpu]") {
  Bench it(test::open_test_gpu());
  NEEDS_GPU(it.gpu);
  // in two runs, as placed and displaced samples are
  it.passes->forward(it.dynamic_gpu, it.rays, {0, kCount});
  it.passes->forward(it.dynamic_gpu, it.rays, {kCount, kCount});
  const Image<float> there = it.get(it.dynamic_gpu.features, 4);
  for (int l = 0; l < 2; ++l) {
    std::vector<float> here(2 * kRow);
    plain::encode(it.networks.dynamic.grid.level(l), it.networks.dynamic.grid.table(l).data(),
                  it.samples(kRow), here.data(), here.data() + kRow);
    check_alike({there.plane(2 * l), 2 * kRow}, here, 1e-5f);
  }
}

TEST_CASE("the networks on the graphics device and their gradients are those of double precision", "[gpu]") {
  Bench it(test::open_test_gpu());
  NEEDS_GPU(it.gpu);
  for (const auto& [branch, there] :
       {std::pair(&it.networks.static_, &it.static_gpu), std::pair(&it.networks.dynamic, &it.dynamic_gpu)}) {
    INFO(branch->mlp.outputs() << " outputs");
    const Image<float> d_raw = it.rows(GpuRays::kGradientPlanes, -1, 1);
    it.put(d_raw, it.rays.d_raw);
    it.passes->forward(*there, it.rays, {0, kRow});
    it.passes->backward(*there, it.rays, {0, kRow});
    it.passes->add_up(*there, kRow, kRow);
    const Image<float> raw = it.get(it.rays.raw, GpuRays::kRawPlanes),
                       features = it.get(there->features, there->inputs);
    const Image<float> d_features = it.get(there->d_features, there->inputs);

    const Mlp<double> mlp = doubled(branch->mlp);
    MlpTrace<double> trace;
    for (auto* hidden : {&trace.hidden[0], &trace.hidden[1], &trace.d_hidden[0], &trace.d_hidden[1]})
      *hidden = Image<double>(mlp.hidden(), 1, kRow);
    Image<double> y(mlp.outputs(), 1, kRow), d_y(mlp.outputs(), 1, kRow), d_x(mlp.inputs(), 1, kRow);
    std::copy_n(d_raw.plane(there->plane_of_raw), d_y.size(), d_y.plane(0));
    std::vector<double> d_parameters(mlp.parameters().size());
    const Image<double> x = doubled(features);
    mlp.forward(x, kRow, trace, y);
    mlp.backward(x, d_y, kRow, trace, d_parameters, d_x);
    check_alike({raw.plane(there->plane_of_raw), y.size()}, rounded(y.samples()), 1e-5f);
    check_alike(d_features.samples(), rounded(d_x.samples()), 1e-5f);

    std::vector<float> tiles(d_parameters.size()), d_network(d_parameters.size());
    it.work().download(**there->d_network, std::as_writable_bytes(std::span(tiles)));
    require_done(it.work().finish());
    untile(branch->mlp, tiles, d_network);
    check_alike(d_network, rounded(d_parameters), 1e-4f);

    const int chunks = GpuBranch::chunks(kRow);
    const Image<float> energy = it.get(there->energy, there->inputs, chunks);
    const Image<float> peaks = it.get(there->peaks, 1, there->levels);
    double there_in_all = 0, in_all = 0;
    for (const float e : energy.samples()) there_in_all += static_cast<double>(e);
    for (const float d : d_features.samples()) in_all += static_cast<double>(d) * static_cast<double>(d);
    CHECK(there_in_all == Approx(in_all).epsilon(1e-5));
    for (int l = 0; l < there->levels; ++l) {
      float largest = 0;
      for (int s = 0; s < 2 * kRow; ++s) largest = std::max(largest, std::abs(d_features.plane(2 * l)[s]));
      CHECK(peaks.plane(0)[l] == largest);
    }
  }
}

TEST_CASE("gradients scattered on the graphics device are added up without loss, large beside small",
          "[gpu]") {
  Bench it(test::open_test_gpu());
  NEEDS_GPU(it.gpu);
  HashGrid<float>& grid = it.networks.dynamic.grid;
  // a level with gradients of 1 and of a ten-millionth, in slots of their own, and one with small ones only
  Image<float> d_features = it.rows(4, -1, 1);
  for (int f = 0; f < 4; ++f)
    for (int s = 0; s < kRow; ++s)
      if (f >= 2 || it.slot[static_cast<std::size_t>(s)] == 1) d_features.plane(f)[s] *= 1e-7f;
  it.put(d_features, it.dynamic_gpu.d_features);
  const std::uint32_t no_peaks[2] = {std::bit_cast<std::uint32_t>(1.f), std::bit_cast<std::uint32_t>(1e-7f)};
  it.work().upload(std::as_bytes(std::span(no_peaks)), **it.dynamic_gpu.peaks);
  it.passes->scatter(it.dynamic_gpu, it.rays, kRow);
  const std::vector<float> there = it.table_gradient(kRow);
  const Image<double> position = doubled(it.position), d = doubled(d_features);
  const GridSamples<double> samples{position, it.slot, kRow};
  const std::size_t level_size = grid.table(0).size(), slot_size = level_size / 4;
  for (int l = 0; l < 2; ++l) {
    std::vector<double> here(level_size);
    plain::scatter(grid.level(l), here.data(), samples, d.plane(2 * l), d.plane(2 * l + 1));
    for (std::size_t i = 0; i < level_size; ++i) {
      // the unit of the first level is 2^-39, of the second 2^-62; some twenty terms are rounded to it
      const double margin = l == 1 ? 1e-12 : i / slot_size == 1 ? 2e-11 : 2e-6;
      INFO("level " << l << ", value " << i);
      REQUIRE(there[static_cast<std::size_t>(l) * level_size + i] ==
              Approx(here[i]).epsilon(1e-4).margin(margin));
    }
  }
}

TEST_CASE("the sum of gradients on the graphics device does not depend on the order of the samples",
          "[gpu]") {
  Bench it(test::open_test_gpu());
  NEEDS_GPU(it.gpu);
  const Image<float> d_features = it.rows(4, -1, 1);
  const auto scattered = [&](bool reversed) {
    Image<float> position(4, 1, kRow), d(4, 1, kRow);
    for (int s = 0; s < kRow; ++s)
      for (int i = 0; i < 4; ++i) {
        const int from = reversed ? kRow - 1 - s : s;
        position.plane(i)[s] = it.position.plane(i)[from], d.plane(i)[s] = d_features.plane(i)[from];
      }
    it.put(position, it.rays.placed), it.put(d, it.dynamic_gpu.d_features);
    const std::uint32_t peaks[2] = {std::bit_cast<std::uint32_t>(1.f), std::bit_cast<std::uint32_t>(1.f)};
    it.work().upload(std::as_bytes(std::span(peaks)), **it.dynamic_gpu.peaks);
    it.passes->scatter(it.dynamic_gpu, it.rays, kRow);
    return it.table_gradient(kRow);
  };
  const std::vector<float> forward = scattered(false), backward = scattered(true);
  CHECK(std::any_of(forward.begin(), forward.end(), [](float v) { return v != 0; }));
  CHECK(forward == backward);
}

TEST_CASE("Adam on the graphics device moves what has a gradient, as the processor does, and nothing else",
          "[gpu]") {
  Bench it(test::open_test_gpu());
  NEEDS_GPU(it.gpu);
  HashGrid<float>& grid = it.networks.dynamic.grid;
  const Mlp<float>& mlp = it.networks.dynamic.mlp;
  Image<float> d_features = it.rows(4, -1, 1);
  it.put(d_features, it.dynamic_gpu.d_features);
  std::vector<float> d_network(mlp.parameters().size());
  for (std::size_t i = 0; i < d_network.size(); i += 3) d_network[i] = it.random.uniform(-1, 1);
  const std::uint32_t peaks[2] = {std::bit_cast<std::uint32_t>(1.f), std::bit_cast<std::uint32_t>(1.f)};
  it.work().upload(std::as_bytes(std::span(peaks)), **it.dynamic_gpu.peaks);
  it.work().upload(std::as_bytes(std::span<const float>(tiled(mlp, d_network))), **it.dynamic_gpu.d_network);
  // few samples, so that most entries have none; and inside of cells, as a weight of 1e-17 is none there
  constexpr int kFew = 8;
  for (int i = 0; i < 4; ++i) std::copy_n(it.position.plane(i) + 10, kFew, it.position.plane(i));
  std::copy_n(it.slot.begin() + 10, kFew, it.slot.begin());
  it.put(it.position, it.rays.placed);
  it.passes->scatter(it.dynamic_gpu, it.rays, kFew);
  const AdamStep table_step = adam_step({}, 0.01f, 0.5f, 3), network_step = adam_step({}, 0.002f, 0.5f, 3);
  it.passes->adam(it.dynamic_gpu, table_step, network_step, kFew);

  const std::size_t level_size = grid.table(0).size();
  std::vector<float> table(it.dynamic_branch.branch.grid.tables().samples().begin(),
                           it.dynamic_branch.branch.grid.tables().samples().end());
  std::vector<float> d_table(table.size()),
      mean(it.dynamic_branch.table_mean.samples().begin(), it.dynamic_branch.table_mean.samples().end());
  std::vector<float> variance(it.dynamic_branch.table_variance.samples().begin(),
                              it.dynamic_branch.table_variance.samples().end());
  for (int l = 0; l < 2; ++l)
    plain::scatter(grid.level(l), d_table.data() + static_cast<std::size_t>(l) * level_size, it.samples(kFew),
                   d_features.plane(2 * l), d_features.plane(2 * l + 1));
  std::vector<float> network(mlp.parameters().begin(), mlp.parameters().end()),
      network_mean = it.dynamic_branch.network.mean;
  std::vector<float> network_variance = it.dynamic_branch.network.variance;
  const std::vector<float> before = table, touched = d_table;
  plain::adam(table_step, table.size(), table.data(), d_table.data(), mean.data(), variance.data());
  plain::adam(network_step, network.size(), network.data(), d_network.data(), network_mean.data(),
              network_variance.data());
  it.collect();
  const auto moved = it.dynamic_branch.branch.grid.tables().samples();
  check_alike(moved, table, 1e-5f);
  check_alike(it.dynamic_branch.table_mean.samples(), mean, 1e-5f);
  check_alike(it.dynamic_branch.table_variance.samples(), variance, 1e-5f);
  check_alike(mlp.parameters(), network, 1e-5f);
  check_alike(it.dynamic_branch.network.mean, network_mean, 1e-5f);
  check_alike(it.dynamic_branch.network.variance, network_variance, 1e-5f);
  std::size_t left = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (touched[i] != 0) continue;
    REQUIRE(moved[i] == before[i]);
    ++left;
  }
  CHECK(left > before.size() / 2);
  // and what was added up is gone
  CHECK(it.table_gradient(kFew) == std::vector<float>(before.size(), 0.f));
}
