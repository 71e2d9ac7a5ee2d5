// A keyframe and the two around a time: their cameras, and which of them is near.
#include "render/views/keyframe.h"

#include "render/views/keyframe_interval.h"
#include "tests/support/state_estimate.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr double kTurn = 0.4;  // radians, about the vertical axis

RigidTransform camera(double turn, double x, double z) {
  return {rotation(Eigen::Vector3d(0, turn, 0)), Eigen::Vector3d(x, 0, z)};
}

Keyframe keyframe(double time_s, const RigidTransform& T_world_camera) {
  Keyframe key;
  key.time_s = time_s, key.T_world_camera = T_world_camera;
  return key;
}

void check_alike(const RigidTransform& a, const RigidTransform& b) {
  CHECK((a.R - b.R).norm() == Approx(0).margin(1e-9));
  CHECK((a.t - b.t).norm() == Approx(0).margin(1e-9));
}

}  // namespace

TEST_CASE("between two keyframes the camera turns and moves evenly, and goes on beyond them") {
  const RigidTransform begin = camera(0.1, 1, 0), end = camera(0.1 + kTurn, 3, 1);
  for (const double share : {0.0, 0.25, 1.0, 2.0, -0.5}) {
    CAPTURE(share);
    check_alike(between(begin, end, share), camera(0.1 + share * kTurn, 1 + 2 * share, share));
  }
}

TEST_CASE("a time between two keyframes has its camera and a nearest one; at an end there is but one") {
  const Keyframe begin = keyframe(2, camera(0, 0, 0)), end = keyframe(4, camera(kTurn, 2, 0));
  const KeyframeInterval early{&begin, &end, 0.25}, late{&begin, &end, 0.75};
  CHECK(early.time_s() == 2.5);
  CHECK(early.lies_between());
  CHECK(&early.nearest() == &begin);
  CHECK(&late.nearest() == &end);
  check_alike(late.T_world_camera(), camera(0.75 * kTurn, 1.5, 0));

  const KeyframeInterval at_begin{&begin, &end, 0}, last{&end, nullptr, 0}, first{nullptr, &begin, 1};
  CHECK_FALSE(at_begin.lies_between());
  CHECK_FALSE(last.lies_between());
  CHECK(&last.nearest() == &end);
  CHECK(last.time_s() == 4);
  check_alike(last.T_world_camera(), end.T_world_camera);
  CHECK(&first.nearest() == &begin);
  CHECK(first.time_s() == 2);
  check_alike(first.T_world_camera(), begin.T_world_camera);
}

TEST_CASE("a keyframe that is used again holds nothing of the frame before") {
  constexpr int kRows = 4, kCols = 6;
  const ExposedFrame input;
  const RadianceEstimate state;
  const Image<float> own_share;
  FrameEstimate estimate = test::estimate_by_state(input, state, own_share);
  estimate.view.time_s = 3, estimate.view.T_world_camera = camera(kTurn, 1, 2);
  estimate.world = 5, estimate.depth_unit = 0.5f;
  HdrFrame frame;
  frame.radiance = Image<float>(3, kRows, kCols), frame.radiance.fill(7);
  frame.sigma = Image<float>(1, kRows, kCols);
  frame.provenance = Image<std::uint8_t>(1, kRows, kCols);

  Keyframe key;
  key.frame.flow = Image<float>(2, kRows, kCols);
  key.inverse_depth = Image<float>(1, kRows, kCols);
  for (FlowField* flow : {&key.to_previous, &key.from_previous})
    flow->vectors = Image<float>(2, kRows, kCols), flow->confidence = Image<float>(1, kRows, kCols);
  take_keyframe(frame, estimate, key);
  CHECK(key.frame.radiance.at(2, 3, 5) == 7);
  CHECK(key.time_s == 3);
  CHECK(key.world == 5);
  CHECK(key.depth_unit == 0.5f);
  CHECK(key.T_world_camera == estimate.view.T_world_camera);
  CHECK(key.frame.flow.empty());
  CHECK(key.inverse_depth.empty());
  CHECK_FALSE(key.knows_depth);
  for (const FlowField* flow : {&key.to_previous, &key.from_previous}) {
    CHECK(flow->vectors.empty());
    CHECK(flow->confidence.empty());
  }
  DepthMap depth{Image<float>(1, 2, 3), Image<float>(1, 2, 3)};
  estimate.depth = &depth;
  depth.weight.fill(DepthMap::kBelieved / 2);
  take_keyframe(frame, estimate, key);
  CHECK_FALSE(key.knows_depth);
  depth.weight.at(0, 1, 1) = 0.9f;
  take_keyframe(frame, estimate, key);
  CHECK(key.knows_depth);
}
