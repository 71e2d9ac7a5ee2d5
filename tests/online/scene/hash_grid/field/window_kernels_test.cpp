#include "online/scene/hash_grid/field/window_kernels.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "online/scene/hash_grid/field/view_geometry.h"
#include "online/scene/hash_grid/field/window.h"
#include "tests/support/numbers.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::Numbers;
using test::Row;

namespace {

constexpr std::array<int, 5> kSizes{1, 7, 8, 64, 331};  // around a vector and around a block
constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

const WindowFrustum kFrustum{{310, 305, 160, 118}, 240, 320, 1.25f, 0.8f};

struct Lifted {
  Row u, v, sure;
};
Lifted lift(const Row& dx, const Row& dy, const Row& confidence, const Row& surface,
            const RigidTransform& T_anchor_here, const RigidTransform& T_anchor_there) {
  Lifted out{Row(dx.size()), Row(dx.size()), Row(dx.size())};
  const Intrinsics& camera = kFrustum.camera;
  const ViewGeometry<float> here(kFrustum, T_anchor_here), there(kFrustum, T_anchor_there);
  window_kernels().lift({dx.data(),
                         dy.data(),
                         confidence.data(),
                         surface.data(),
                         3.5f,
                         100.5f,
                         here.to_anchor(),
                         there.to_anchor(),
                         {static_cast<float>(camera.fx_px), static_cast<float>(camera.fy_px)},
                         {static_cast<float>(camera.cx_px), static_cast<float>(camera.cy_px)},
                         ViewGeometry<float>::kNearest,
                         512,
                         out.u.data(),
                         out.v.data(),
                         out.sure.data()},
                        static_cast<int>(dx.size()));
  return out;
}

}  // namespace

TEST_CASE("a lifted flow is the way between its two surface points, in pixels of the anchor", "[isa]") {
  Numbers numbers(7);
  const RigidTransform T_anchor_here{rotation({0.01, -0.02, 0.005}), {0.02, -0.01, 0.03}};
  const RigidTransform T_anchor_there{rotation({-0.015, 0.01, 0.01}), {-0.03, 0.02, 0.01}};
  const ViewGeometry<double> here(kFrustum, T_anchor_here), there(kFrustum, T_anchor_there);
  for (const int n : kSizes) {
    const Row dx = numbers.between(-20, 20, n), dy = numbers.between(-20, 20, n),
              sure = numbers.between(0, 1, n), surface = numbers.between(0, 1, n);
    const Lifted out = lift(dx, dy, sure, surface, T_anchor_here, T_anchor_there);
    for (std::size_t i = 0; i < dx.size(); ++i) {
      INFO("pixel " << i << " of " << n);
      const double q = static_cast<double>(surface[i]), start[2] = {3.5 + static_cast<double>(i), 100.5};
      const double end[2] = {start[0] + static_cast<double>(dx[i]), start[1] + static_cast<double>(dy[i])};
      double x_start[3], x_end[3];
      here.place(start, q, x_start);
      there.place(end, q, x_end);
      REQUIRE(out.u[i] == Approx((x_end[0] - x_start[0]) / kFrustum.u_per_px()).margin(2e-3));
      REQUIRE(out.v[i] == Approx((x_end[1] - x_start[1]) / kFrustum.v_per_px()).margin(2e-3));
      REQUIRE(out.sure[i] == sure[i]);
    }
  }
}

TEST_CASE("a flow that is not a number is not believed, and a long one is cut", "[isa]") {
  const Row dx{kNan, 1, 1, kInf, 1e30f}, dy{1, kNan, 1, 1, -1e30f}, sure{1, 1, kNan, 1, 2}, surface(5, 0.5f);
  const Lifted out = lift(dx, dy, sure, surface, {}, {});
  for (std::size_t i = 0; i < dx.size(); ++i) {
    INFO("pixel " << i);
    CHECK(std::isfinite(out.u[i]));
    CHECK(std::isfinite(out.v[i]));
    CHECK(out.sure[i] == (i < 4 ? 0.f : 1.f));
  }
  CHECK(out.u[4] == Approx(512).margin(1e-3));
  CHECK(out.v[4] == Approx(-512).margin(1e-3));
}

TEST_CASE("the base of a pixel is its log radiance and what the networks may change", "[isa]") {
  constexpr float kUnseen = 1e6f, kSigma = 0.1f;
  Numbers numbers(7);
  for (const int n : kSizes) {
    Row radiance = numbers.between(-0.1f, 30, n), variance = numbers.between(-0.1f, 2, n);
    radiance[0] = kInf;
    variance[radiance.size() / 2] = kUnseen;
    variance.back() = kNan;
    Row log_radiance(radiance.size()), gate(radiance.size());
    window_kernels().base(
        {radiance.data(), variance.data(), kUnseen, kSigma, log_radiance.data(), gate.data()}, n);
    for (std::size_t i = 0; i < radiance.size(); ++i) {
      INFO("pixel " << i << " of " << n << ": " << radiance[i] << ", variance " << variance[i]);
      const bool known = std::isfinite(radiance[i]);
      const float light = known ? std::clamp(radiance[i], 1e-5f, 1e7f) : 1e-5f;
      REQUIRE(log_radiance[i] == Approx(std::log(light)).margin(1e-5));
      const float spread = std::max(variance[i], 0.f);
      const bool seen = known && std::isfinite(variance[i]) && variance[i] < kUnseen;
      const float open = spread / (spread + kSigma * kSigma * light * light);
      REQUIRE(gate[i] == Approx(seen ? open : 1).margin(1e-6));
    }
  }
}

TEST_CASE("values are codes from 0 to 1, and what is not a code has no value", "[isa]") {
  const Row codes{0, 255, 51, -3, 300, kNan, -kInf};
  Row values(codes.size());
  window_kernels().values({codes.data(), -1, values.data()}, static_cast<int>(codes.size()));
  const Row expected{0, 1, 0.2f, 0, 1, -1, -1};
  for (std::size_t i = 0; i < codes.size(); ++i) CHECK(values[i] == Approx(expected[i]));
}

namespace {

// Pictures of blocks: their rows, the last block of a row being cut off by the picture's edge.
struct Blocked {
  int step, n, cols;
  std::vector<Row> rows;

  Blocked(int step_, int n_, int missing, Numbers& numbers, float low, float high)
      : step(step_), n(n_), cols(n * step - missing) {
    for (int k = 0; k < step; ++k) rows.push_back(numbers.between(low, high, cols));
  }
  BlockRow row() const {
    BlockRow of;
    of.step = step, of.cols = cols;
    for (int k = 0; k < step; ++k) of.row[k] = rows[static_cast<std::size_t>(k)].data();
    return of;
  }
  float& at(int block, int y, int x) {
    return rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(block * step + x)];
  }
  // The scalar twin's pixels of a block, the last ones of a row repeated past the edge.
  std::vector<float> pixels(int block) const {
    std::vector<float> all;
    for (const Row& row : rows)
      for (int x = 0; x < step; ++x)
        all.push_back(row[static_cast<std::size_t>(std::min(block * step + x, cols - 1))]);
    return all;
  }
};

struct BlockSize {
  int step, blocks, missing;  // pixels of the last block
};
constexpr std::array<BlockSize, 7> kBlockSizes{
    {{1, 9, 0}, {2, 1, 1}, {2, 64, 0}, {2, 17, 1}, {4, 33, 3}, {8, 64, 0}, {8, 5, 7}}};

double mean_of(const std::vector<float>& all) {
  double sum = 0;
  for (const float v : all) sum += static_cast<double>(v);
  return sum / static_cast<double>(all.size());
}

Row values_of(const Blocked& codes) {
  Row values(static_cast<std::size_t>(codes.n));
  window_kernels().block_values({codes.row(), 250, -1, values.data()}, codes.n);
  return values;
}

}  // namespace

TEST_CASE("the value of a block is the mean of its codes", "[isa]") {
  Numbers numbers(7);
  for (const auto& [step, n, missing] : kBlockSizes) {
    INFO(n << " blocks of " << step);
    const Blocked codes(step, n, missing, numbers, 0, 249);
    const Row values = values_of(codes);
    for (int i = 0; i < n; ++i)
      REQUIRE(values[static_cast<std::size_t>(i)] == Approx(mean_of(codes.pixels(i)) / 255).margin(1e-6));
  }
}

TEST_CASE("a block that is clipped stays a bound, and one that is clipped in part has no value", "[isa]") {
  Numbers numbers(7);
  for (const int step : {2, 4, 8}) {
    INFO("blocks of " << step);
    Blocked codes(step, 5, 0, numbers, 10, 200);
    for (int y = 0; y < step; ++y)
      for (int x = 0; x < step; ++x) codes.at(1, y, x) = 255;
    codes.at(2, step - 1, step - 1) = 255;
    codes.at(3, 0, 1) = kNan;
    const Row values = values_of(codes);
    CHECK(values[0] > 0);
    CHECK(values[0] < 0.8f);
    CHECK(values[1] == 1);
    CHECK(values[2] == -1);
    CHECK(values[3] == -1);
    CHECK(values[4] > 0);
  }
}

TEST_CASE("the state of a block is its mean light, and unseen where one of its pixels is", "[isa]") {
  constexpr float kUnseen = 40;
  Numbers numbers(7);
  for (const auto& [step, n, missing] : kBlockSizes) {
    INFO(n << " blocks of " << step);
    Blocked radiance(step, n, missing, numbers, 0, 30), variance(step, n, missing, numbers, 0, 2);
    if (n > 4) {
      variance.at(0, 0, 0) = kUnseen;
      variance.at(2, step - 1, 0) = kNan;
      radiance.at(3, 0, 0) = kInf;
    }
    Row mean(static_cast<std::size_t>(n)), spread(mean.size());
    window_kernels().block_state({radiance.row(), variance.row(), kUnseen, mean.data(), spread.data()}, n);
    for (int i = 0; i < n; ++i) {
      INFO("block " << i);
      const auto at = static_cast<std::size_t>(i);
      const bool lost = n > 4 && (i == 0 || i == 2 || i == 3);
      REQUIRE(std::isfinite(mean[at]));
      if (!(n > 4 && i == 3)) REQUIRE(mean[at] == Approx(mean_of(radiance.pixels(i))).margin(1e-5));
      if (lost)
        REQUIRE(spread[at] == kUnseen);
      else
        REQUIRE(spread[at] == Approx(mean_of(variance.pixels(i)) / (step * step)).margin(1e-6));
    }
  }
}

TEST_CASE("the motion of a block, in blocks, is that of its pixels as far as it is believed", "[isa]") {
  Numbers numbers(7);
  for (const auto& [step, n, missing] : kBlockSizes) {
    INFO(n << " blocks of " << step);
    Blocked dx(step, n, missing, numbers, -20, 20), dy(step, n, missing, numbers, -20, 20);
    const Blocked sure(step, n, missing, numbers, 0, 1);
    if (n > 4) dx.at(1, 0, 0) = kNan;
    Row x(static_cast<std::size_t>(n)), y(x.size()), confidence(x.size());
    window_kernels().block_flow({dx.row(), dy.row(), sure.row(), x.data(), y.data(), confidence.data()}, n);
    for (int i = 0; i < n; ++i) {
      INFO("block " << i);
      const auto at = static_cast<std::size_t>(i);
      const auto us = dx.pixels(i), vs = dy.pixels(i), weights = sure.pixels(i);
      constexpr double kLeast = 1e-3;  // what is not believed counts that much
      double u = 0, v = 0, weight = 0;
      for (std::size_t p = 0; p < us.size(); ++p) {
        const bool known = std::isfinite(us[p]);
        const double believed = known ? static_cast<double>(weights[p]) : 0, w = believed + kLeast;
        if (known) u += w * static_cast<double>(us[p]);
        v += w * static_cast<double>(vs[p]), weight += believed;
      }
      const auto pixels = static_cast<double>(us.size());
      REQUIRE(confidence[at] == Approx(weight / pixels).margin(1e-6));
      REQUIRE(x[at] == Approx(u / (weight + kLeast * pixels) / step).margin(1e-3));
      REQUIRE(y[at] == Approx(v / (weight + kLeast * pixels) / step).margin(1e-3));
    }
  }
}

TEST_CASE("a pixel that lost its match does not turn its block's motion, and a block of them has the mean",
          "[isa]") {
  Numbers numbers(7);
  Blocked dx(2, 2, 0, numbers, 4, 4), dy(2, 2, 0, numbers, -2, -2), sure(2, 2, 0, numbers, 1, 1);
  dx.at(0, 1, 1) = 400, sure.at(0, 1, 1) = 0;
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x) sure.at(1, y, x) = 0;
  float x[2], y[2], confidence[2];
  window_kernels().block_flow({dx.row(), dy.row(), sure.row(), x, y, confidence}, 2);
  CHECK(x[0] == Approx(2).margin(0.1));  // 4 px are two blocks
  CHECK(y[0] == Approx(-1).margin(1e-3));
  CHECK(confidence[0] == 0.75f);
  CHECK(x[1] == Approx(2).margin(1e-3));
  CHECK(confidence[1] == 0);
}

TEST_CASE("a place that is not a number has the base of the picture's last pixel, as on a graphics device") {
  Image<BasePixel> base(1, 3, 4);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) base.at(0, y, x).fill(static_cast<float>(10 * y + x));
  float value[kBaseChannels], d_x[kBaseChannels], d_y[kBaseChannels];
  const float nowhere[] = {kNan, kNan}, left[] = {-kInf, 1.5f}, right[] = {kInf, 1.5f};
  fetch_base(base, nowhere, value, d_x, d_y);
  CHECK(value[0] == 23);
  CHECK(d_x[0] == 0);
  CHECK(d_y[0] == 0);
  fetch_base(base, left, value);
  CHECK(value[0] == 10);
  fetch_base(base, right, value);
  CHECK(value[0] == 13);
}
