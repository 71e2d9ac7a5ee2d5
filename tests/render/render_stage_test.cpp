// Which layers a frame is emitted with, from whom they are, and in which units.
#include "render/render_stage.h"

#include <cstddef>

#include "tests/support/state_estimate.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 12, kCols = 16;
constexpr float kOfState = 1, kOfField = 5, kFieldDepth = 2, kDepthUnit = 0.5f;
constexpr float kMotion_px = 8;  // of the field, from frame to frame, in a picture of full size

// A field that is alike everywhere and counts how often it is asked.
class EvenField final : public FieldSnapshot {
 public:
  void look(const SceneView& view, WorkerPool&, FieldPicture& picture) const override {
    ++asked_;
    picture.radiance.reshape(3, view.rows, view.cols), picture.radiance.fill(kOfField);
    picture.depth.reshape(1, view.rows, view.cols), picture.depth.fill(kFieldDepth);
    for (const Neighbour toward : {Neighbour::Previous, Neighbour::Next}) {
      const float motion = kMotion_px * static_cast<float>(view.cols) / kCols;
      Image<float>& flow = picture.flow[static_cast<std::size_t>(toward)];
      flow.reshape(2, view.rows, view.cols), flow.fill(toward == Neighbour::Previous ? -motion : motion);
    }
  }
  int asked() const { return asked_; }

 private:
  mutable int asked_ = 0;
};

// A frame of a state that saw everything, beside such a field.
struct EvenScene {
  WorkerPool pool{2};
  EvenField field;
  ExposedFrame input;
  RadianceEstimate state{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols)};
  Image<float> own_share{1, kRows, kCols};
  DepthMap measured{Image<float>(1, kRows, kCols), Image<float>(1, kRows, kCols)};
  HdrFrame frame;

  EvenScene() {
    state.radiance.fill(kOfState), state.variance.fill(1e-4f), own_share.fill(1);
    measured.weight.at(0, 3, 5) = 0.9f;
  }
  void render(const RenderOptions& options, int step = 2) {
    FrameEstimate estimate = test::estimate_by_state(input, state, own_share);
    estimate.field = FieldNow(SnapshotHold(field));
    estimate.view.rows = kRows, estimate.view.cols = kCols;
    estimate.depth = &measured;
    estimate.depth_unit = kDepthUnit;
    estimate.budget.shrinkage = ShrinkageEffort::Off;
    estimate.budget.render_step = step;
    RenderStage(options, pool).render(estimate, frame);
  }
};

void check_even(const Image<float>& layer, int channels, float value) {
  REQUIRE(layer.channels() == channels);
  REQUIRE(layer.rows() == kRows);
  REQUIRE(layer.cols() == kCols);
  for (const float v : layer.samples()) REQUIRE(v == Approx(value));
}

void check_from(const Image<std::uint8_t>& provenance, Provenance from) {
  REQUIRE(provenance.size() == kRows * kCols);
  for (const std::uint8_t p : provenance.samples()) REQUIRE(p == static_cast<std::uint8_t>(from));
}

}  // namespace

TEST_CASE("the state alone asks the field for nothing, and shows nothing of it") {
  EvenScene scene;
  scene.render({.layer = EmitLayer::State, .depth = DepthLayer::Whole, .shows_field_flow = true});
  CHECK(scene.field.asked() == 0);
  check_even(scene.frame.radiance, 3, kOfState);
  check_from(scene.frame.provenance, Provenance::Own);
  for (const Image<float>* layer :
       {&scene.frame.depth, &scene.frame.field_flow, &scene.frame.field_flow_forward})
    CHECK(layer->empty());
}

TEST_CASE("the field alone gives every pixel") {
  EvenScene scene;
  scene.render({.layer = EmitLayer::Field});
  CHECK(scene.field.asked() == 1);
  check_even(scene.frame.radiance, 3, kOfField);
  check_from(scene.frame.provenance, Provenance::Field);
  CHECK(scene.frame.depth.empty());
}

TEST_CASE(
    "depth and motion of the field have the size and the units of the frame, at whatever step it is seen") {
  for (const int step : {1, 2, 4}) {
    CAPTURE(step);
    EvenScene scene;
    scene.render({.depth = DepthLayer::Whole, .shows_field_flow = true}, step);
    CHECK(scene.field.asked() == 1);
    check_even(scene.frame.radiance, 3, kOfState);
    check_even(scene.frame.depth, 1, kFieldDepth * kDepthUnit);
    check_even(scene.frame.field_flow, 2, -kMotion_px);
    check_even(scene.frame.field_flow_forward, 2, kMotion_px);
    scene.render({.depth = DepthLayer::Glance}, step);
    check_even(scene.frame.depth, 1, kFieldDepth * kDepthUnit);
    CHECK(scene.frame.field_flow.empty());
  }
}

TEST_CASE("a frame has no depth while nothing of the scene has a known one") {
  EvenScene scene;
  scene.measured.weight.fill(DepthMap::kBelieved / 2);
  scene.render({.depth = DepthLayer::Whole, .shows_field_flow = true});
  CHECK(scene.frame.depth.empty());
  check_even(scene.frame.field_flow, 2, -kMotion_px);
}
