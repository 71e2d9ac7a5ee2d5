#include "online/priors/pose/known_pose.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace hdrcam;

namespace {

const RigidTransform kIdentity;

FrameFacts at(const RigidTransform& T_world_camera) {
  FrameFacts facts;
  facts.T_world_camera = pose_matrix_of(T_world_camera);
  return facts;
}

}  // namespace

TEST_CASE("a fixed camera is the identity, whatever the flow", "[pose]") {
  FixedPose pose;
  ExposedFrame frame;
  frame.facts = at({rotation({0, 1, 0}), {1, 2, 3}});
  const CameraPose& seen = pose.estimate({frame, {}, {}});
  CHECK(seen.T_world_camera == kIdentity);
}

TEST_CASE("given poses are relative to the first frame", "[pose]") {
  GivenPose pose;
  const RigidTransform first{rotation({0.3, -0.2, 0.1}), {1, 2, 3}};
  const RigidTransform step{rotation({0, 0.02, 0}), {0.1, 0, 0.05}};
  const RigidTransform start = pose.next(at(first)).T_world_camera;
  CHECK((start.R - Eigen::Matrix3d::Identity()).norm() < 1e-12);
  CHECK(start.t.norm() < 1e-12);
  const CameraPose& second = pose.next(at(first * step));
  CHECK((second.T_world_camera.R - step.R).norm() < 1e-12);
  CHECK((second.T_world_camera.t - step.t).norm() < 1e-12);
}

TEST_CASE("a frame without a usable pose keeps the last one and says so", "[pose]") {
  GivenPose pose;
  pose.next(at({}));
  const RigidTransform before = pose.next(at({rotation({0, 0.01, 0}), {1, 0, 0}})).T_world_camera;
  CHECK(pose.next({}).lost);
  CHECK(pose.next(at({Eigen::Matrix3d::Identity(), {NAN, 0, 0}})).lost);
  CHECK(pose.next({}).T_world_camera == before);
  CHECK_FALSE(pose.next(at({})).lost);
}
