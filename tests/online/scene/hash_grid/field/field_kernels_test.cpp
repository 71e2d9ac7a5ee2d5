// The kernels that this processor picks against their readable twins.
#include "online/scene/hash_grid/field/field_kernels.h"

#include "online/scene/hash_grid/field/hash_grid.h"
#include "online/scene/hash_grid/field/mlp.h"
#include "online/scene/hash_grid/fit/adam.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kSamples = 96;

Image<float> random_rows(int rows, Pcg32& random, float low, float high) {
  Image<float> values(rows, 1, kSamples);
  for (float& v : values.samples()) v = random.uniform(low, high);
  return values;
}

void require_same(std::span<const float> a, std::span<const float> b, float tolerance) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    INFO("entry " << i);
    REQUIRE(a[i] == Approx(b[i]).margin(tolerance));
  }
}

struct Grid {
  Pcg32 random{4};
  HashGrid<float> grid{{5, 9, 3, 4, 64, 0.75f, 0.5f}, 1, random};
  Image<float> position = random_rows(3, random, -0.1f, 1.1f);
  std::vector<std::int32_t> slot = std::vector<std::int32_t>(kSamples);
  Image<float> d_features = random_rows(10, random, -1, 1);

  Grid() {
    for (auto& s : slot) s = random.below(3);
    const float edges[] = {0, 1, 0.25f, 0.9999999f, -1e30f, 1e30f};
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < 6; ++i) position.plane(axis)[i] = edges[i];
  }
  GridSamples<float> samples() const { return {position, slot, kSamples}; }
};

}  // namespace

TEST_CASE("a grid level encodes, scatters and differentiates like its readable twin",
          "[isa][field][kernels]") {
  Grid it;
  for (int l = 0; l < 5; ++l) {
    INFO("level " << l << (it.grid.level(l).dense ? ", dense" : ", hashed"));
    const GridQuery query{
        {it.position.plane(0), it.position.plane(1), it.position.plane(2)}, it.slot.data(), kSamples};
    const float *table = it.grid.table(l).data(), *d0 = it.d_features.plane(2 * l),
                *d1 = it.d_features.plane(2 * l + 1);

    std::vector<float> fast(2 * kSamples), slow(2 * kSamples);
    field_kernels().encode(it.grid.level(l), table, query, fast.data(), fast.data() + kSamples);
    plain::encode(it.grid.level(l), table, it.samples(), slow.data(), slow.data() + kSamples);
    require_same(fast, slow, 1e-4f);

    std::vector<float> d_fast(it.grid.table(l).size()), d_slow(d_fast.size());
    field_kernels().scatter(it.grid.level(l), d_fast.data(), query, d0, d1);
    plain::scatter(it.grid.level(l), d_slow.data(), it.samples(), d0, d1);
    require_same(d_fast, d_slow, 1e-4f);

    Image<float> p_fast(3, 1, kSamples), p_slow(3, 1, kSamples);
    float* const rows[3] = {p_fast.plane(0), p_fast.plane(1), p_fast.plane(2)};
    field_kernels().position_backward(it.grid.level(l), table, query, d0, d1, rows);
    plain::position_backward(it.grid.level(l), table, it.samples(), d0, d1, p_slow);
    require_same(p_fast.samples(), p_slow.samples(), 2e-2f);
  }
}

TEST_CASE("grid levels have the sizes that arithmetic by hand gives", "[isa][field]") {
  // 4 x 3 x 2 cells have 5 * 4 * 3 = 60 vertices; 64 x 48 x 32 have 65 * 49 * 33 = 105105, more than 2^9
  const auto levels = hash_levels({5, 9, 1, 4, 64, 0.75f, 0.5f});
  REQUIRE(levels.size() == 5);
  CHECK(levels[0].dense);
  CHECK(levels[0].stride[1] == 5);
  CHECK(levels[0].stride[2] == 20);
  CHECK_FALSE(levels[4].dense);
  CHECK(levels[4].cells[0] == 64);
  CHECK(levels[4].cells[1] == 48);
  CHECK(levels[2].cells[0] == 16);
}

TEST_CASE("the matrix kernels agree with their readable twins", "[isa][field][kernels]") {
  Pcg32 random(6);
  for (const auto& [in, out] : {std::pair{8, 32}, {16, 32}, {32, 32}, {32, 12}, {32, 8}}) {
    INFO(in << " -> " << out);
    const LayerSize size{.in = in, .out = out, .ld = kSamples, .n = kSamples};
    std::vector<float> w(static_cast<std::size_t>(in * out)), b(static_cast<std::size_t>(out));
    for (float& v : w) v = random.uniform(-1, 1);
    for (float& v : b) v = random.uniform(-1, 1);
    const Image<float> x = random_rows(in, random, -1, 1), dy = random_rows(out, random, -1, 1);

    Image<float> y_fast(out, 1, kSamples), y_slow(out, 1, kSamples);
    for (bool relu : {true, false}) {
      field_kernels().affine(size, w.data(), b.data(), x.plane(0), relu, y_fast.plane(0));
      plain::affine(size, w.data(), b.data(), x.plane(0), relu, y_slow.plane(0));
      require_same(y_fast.samples(), y_slow.samples(), 1e-4f);
    }
    Image<float> x_fast(in, 1, kSamples), x_slow(in, 1, kSamples);
    for (const float* active : {x.plane(0), static_cast<const float*>(nullptr)}) {
      field_kernels().affine_transposed(size, w.data(), dy.plane(0), active, x_fast.plane(0));
      plain::affine_transposed(size, w.data(), dy.plane(0), active, x_slow.plane(0));
      require_same(x_fast.samples(), x_slow.samples(), 1e-4f);
    }
    std::vector<float> dw_fast(w.size()), dw_slow(w.size()), db_fast(b.size()), db_slow(b.size());
    field_kernels().outer(size, dy.plane(0), x.plane(0), dw_fast.data(), db_fast.data());
    plain::outer(size, dy.plane(0), x.plane(0), dw_slow.data(), db_slow.data());
    require_same(dw_fast, dw_slow, 1e-3f);
    require_same(db_fast, db_slow, 1e-3f);
  }
}

TEST_CASE("Adam moves only what has a gradient, like its readable twin", "[isa][field][kernels]") {
  Pcg32 random(7);
  constexpr std::size_t kCount = 1000;  // not a multiple of anything
  std::vector<float> parameter(kCount), gradient(kCount, 0), mean(kCount, 0.1f), variance(kCount, 0.2f);
  for (float& p : parameter) p = random.uniform(-1, 1);
  for (std::size_t i = 0; i < kCount; i += 7) gradient[i] = random.uniform(-1, 1);
  auto p2 = parameter, g2 = gradient, m2 = mean, v2 = variance;
  const auto untouched = parameter[1];
  const AdamStep step = adam_step({}, 0.01f, 0.5f, 3);
  apply_adam(step, parameter, gradient, mean.data(), variance.data());
  plain::adam(step, kCount, p2.data(), g2.data(), m2.data(), v2.data());
  require_same(parameter, p2, 1e-6f);
  require_same(mean, m2, 1e-6f);
  require_same(variance, v2, 1e-6f);
  CHECK(parameter[1] == untouched);
  CHECK(mean[1] == 0.1f);
  for (float g : gradient) CHECK(g == 0);
}
