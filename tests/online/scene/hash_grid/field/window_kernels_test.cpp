#include "online/scene/hash_grid/field/window_kernels.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "online/scene/hash_grid/field/view_geometry.h"
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

TEST_CASE("values are codes from 0 to 1, and what is not a code is none", "[isa]") {
  const Row codes{0, 255, 51, -3, 300, kNan, -kInf};
  Row values(codes.size());
  window_kernels().values({codes.data(), -1, values.data()}, static_cast<int>(codes.size()));
  const Row expected{0, 1, 0.2f, 0, 1, -1, -1};
  for (std::size_t i = 0; i < codes.size(); ++i) CHECK(values[i] == Approx(expected[i]));
}
