#include "online/state/exposure_blur.h"

#include <algorithm>

#include "online/state/fusion.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 16, kCols = 64, kEdge = 32;
constexpr float kDark = 0.1f, kBright = 0.6f;

Image<float> edge() {
  Image<float> picture(3, kRows, kCols);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) picture.at(c, y, x) = x < kEdge ? kDark : kBright;
  return picture;
}

// What is left of the edge after a blur of so many pixels: a ramp around it.
float ramp(int x, float length_px) {
  const float along = (static_cast<float>(x - kEdge) + 0.5f) / length_px + 0.5f;
  return kDark + (kBright - kDark) * std::clamp(along, 0.f, 1.f);
}

Image<float> to_the_right(float px) {
  Image<float> flow(2, kRows, kCols);
  std::fill_n(flow.plane(0), flow.plane_size(), px);
  return flow;
}

}  // namespace

TEST_CASE("an edge that moves is blurred over its way during the exposure, and what is at rest is not") {
  WorkerPool pool(2);
  const Image<float> sharp = edge();
  Image<float> added;
  for (const float share : {0.75f, 0.25f}) {
    blur_difference(sharp, to_the_right(8), share, added, pool);
    for (int x = 16; x < 48; ++x) {
      INFO("column " << x << ", exposed for " << share << " of the interval");
      CHECK(sharp.at(1, 8, x) + added.at(1, 8, x) == Approx(ramp(x, share * 8)).margin(0.05));
    }
  }
  blur_difference(sharp, to_the_right(8), 0.02f, added, pool);
  for (const float a : added.samples()) REQUIRE(a == 0);
}

TEST_CASE("an exposure blurs where any motion in it is long enough to be seen", "[isa]") {
  WorkerPool pool(2);
  Image<float> flow(2, kRows, kCols - 1);  // not whole vectors
  flow.fill(0);
  CHECK_FALSE(exposure_blurs(flow, 1, pool));
  flow.at(1, kRows - 1, kCols - 2) = -4;
  CHECK(exposure_blurs(flow, 0.5f, pool));
  CHECK_FALSE(exposure_blurs(flow, 0.05f, pool));
}

TEST_CASE("what is read along a path of two intervals is doubted twice as much as along one") {
  WorkerPool pool(1);
  const Fusion fusion({}, pool);
  const Image<float> flow = to_the_right(2.5f);
  std::vector<float> one(kCols), two(kCols);
  fusion.warp_variance(flow, 3, one.data());
  fusion.warp_variance(flow, 3, two.data(), 2);
  for (int x = 0; x < kCols; ++x) {
    const auto i = static_cast<std::size_t>(x);
    CHECK(one[i] > 0);
    CHECK(two[i] == Approx(2 * one[i]));
  }
}

TEST_CASE("a long exposure of an edge that moves agrees with a sharp state and leaves it sharp") {
  WorkerPool pool(1);
  Fusion fusion({}, pool);
  const float unseen = unseen_variance_from(4);
  const ExposureTables tables(Response::gamma(2.2f), {}, 1);
  Image<float> codes(3, kRows, kCols), confidence(1, kRows, kCols), gate, contrast, share;
  confidence.fill(1);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) codes.at(c, y, x) = tables.code(c, ramp(x, 6));

  struct Outcome {
    float least_gate = 1, largest_error = 0;
  };
  const auto outcome = [&](bool modelled) {
    RadianceState state{edge(), Image<float>(3, kRows, kCols), Image<float>(1, kRows, kCols)};
    Samples samples;
    fusion.sample(codes, codes, tables, samples);
    Outcome out;
    state.variance.fill(1e-4f);
    if (modelled) fusion.model_blur(state, to_the_right(8), 0.75f, samples);
    fusion.gate({state, samples, tables, unseen}, confidence, gate, contrast);
    state.variance.fill(0.01f);
    RadianceState updated;
    fusion.update({state, samples, tables, unseen}, nullptr, nullptr, updated, share);
    for (int x = 16; x < 48; ++x) {
      out.least_gate = std::min(out.least_gate, gate.at(0, 8, x));
      out.largest_error =
          std::max(out.largest_error, std::abs(updated.radiance.at(1, 8, x) - (x < kEdge ? kDark : kBright)));
    }
    return out;
  };
  const Outcome with = outcome(true), without = outcome(false);
  CHECK(with.least_gate > 0.8f);
  CHECK(without.least_gate < 0.5f);
  CHECK(with.largest_error < 0.2f * without.largest_error);
}
