#include "online/state/fusion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/online/state/moving_edge.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::MovingEdge;

TEST_CASE("what is read along a path of two intervals is doubted twice as much as along one") {
  WorkerPool pool(1);
  const Fusion fusion({}, pool);
  const Image<float> flow = MovingEdge::to_the_right(2.5f);
  std::vector<float> one(MovingEdge::kCols), two(MovingEdge::kCols);
  fusion.warp_variance(flow, 3, one.data());
  fusion.warp_variance(flow, 3, two.data(), 2);
  for (int x = 0; x < MovingEdge::kCols; ++x) {
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
  Image<float> codes(3, MovingEdge::kRows, MovingEdge::kCols),
      confidence(1, MovingEdge::kRows, MovingEdge::kCols), gate, contrast, share;
  confidence.fill(1);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < MovingEdge::kRows; ++y)
      for (int x = 0; x < MovingEdge::kCols; ++x) codes.at(c, y, x) = tables.code(c, MovingEdge::ramp(x, 6));

  struct Outcome {
    float least_gate = 1, largest_error = 0;
  };
  const auto outcome = [&](bool modelled) {
    RadianceState state{MovingEdge::picture(), Image<float>(3, MovingEdge::kRows, MovingEdge::kCols),
                        Image<float>(1, MovingEdge::kRows, MovingEdge::kCols)};
    Samples samples;
    fusion.sample(codes, codes, tables, samples);
    Outcome out;
    state.variance.fill(1e-4f);
    if (modelled) fusion.model_blur(state, MovingEdge::to_the_right(8), 0.75f, samples);
    fusion.gate({state, samples, tables, unseen}, confidence, gate, contrast);
    state.variance.fill(0.01f);
    RadianceState updated;
    fusion.update({state, samples, tables, unseen}, nullptr, nullptr, updated, share);
    for (int x = 16; x < 48; ++x) {
      out.least_gate = std::min(out.least_gate, gate.at(0, 8, x));
      out.largest_error =
          std::max(out.largest_error, std::abs(updated.radiance.at(1, 8, x) - MovingEdge::sharp(x)));
    }
    return out;
  };
  const Outcome with = outcome(true), without = outcome(false);
  CHECK(with.least_gate > 0.8f);
  CHECK(without.least_gate < 0.5f);
  CHECK(with.largest_error < 0.2f * without.largest_error);
}
