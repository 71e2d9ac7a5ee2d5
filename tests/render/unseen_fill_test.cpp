#include "render/unseen_fill.h"

#include <algorithm>

#include "tests/support/state_estimate.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 6, kCols = 8, kStep = 2;
constexpr float kUnseenFrom = 10;

// A frame of radiance 1 of which one channel of one pixel was never seen unclipped.
struct Scene {
  WorkerPool pool{2};
  ExposedFrame input;
  RadianceEstimate state{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols)};
  Image<float> own_share{1, kRows, kCols};
  HdrFrame frame;
  Image<float> field{3, kRows / kStep, kCols / kStep};
  const int y = 2, x = 3;

  Scene() {
    state.radiance.fill(1), state.variance.fill(1e-4f);
    state.variance.at(1, y, x) = kUnseenFrom;
    frame.radiance.copy_from(state.radiance);
    frame.provenance.reshape(1, kRows, kCols);
    frame.provenance.fill(static_cast<std::uint8_t>(Provenance::Own));
  }
  FrameEstimate estimate() const {
    FrameEstimate estimate = test::estimate_by_state(input, state, own_share);
    estimate.view.rows = kRows, estimate.view.cols = kCols;
    estimate.unseen_variance = kUnseenFrom;
    return estimate;
  }
  // What becomes of the unseen channel where the field says this.
  float filled(float by_field, float largest_ratio) {
    UnseenFill fill(largest_ratio, pool);
    field.fill(by_field);
    CHECK(fill.mark(estimate(), kStep));
    fill.raise(estimate(), field, kStep, frame);
    return frame.radiance.at(1, y, x);
  }
};

}  // namespace

TEST_CASE("what an unseen pixel reads of the reduced view is marked, and nothing else") {
  Scene scene;
  UnseenFill fill(4, scene.pool);
  CHECK(fill.mark(scene.estimate(), kStep));
  CHECK(fill.marked().rows() == kRows / kStep);
  CHECK(fill.marked().cols() == kCols / kStep);
  CHECK(std::ranges::count(fill.marked().samples(), 1) == 4);
  for (const int v : {0, 1})
    for (const int u : {1, 2}) CHECK(fill.marked().at(0, v, u) == 1);
  scene.state.variance.fill(1e-4f);
  CHECK(!fill.mark(scene.estimate(), kStep));
}

TEST_CASE("an unseen channel rises by half of the stops that the field says, up to a ratio; the rest stays") {
  Scene scene;
  CHECK(scene.filled(4, 100) == 2);
  CHECK(scene.frame.radiance.at(0, scene.y, scene.x) == 1);
  CHECK(scene.frame.radiance.at(1, scene.y, scene.x + 1) == 1);
  CHECK(scene.frame.provenance.at(0, scene.y, scene.x) == static_cast<std::uint8_t>(Provenance::Field));
  CHECK(scene.frame.provenance.at(0, scene.y, scene.x + 1) == static_cast<std::uint8_t>(Provenance::Own));
  CHECK(Scene().filled(4, 2.25f) == 1.5f);
  CHECK(Scene().filled(0.5f, 4) == 1);
}
