#include "online/priors/pose/tracked_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "tests/online/priors/pose/synthetic_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace hdrcam::test;

namespace {

constexpr double kDegree = std::numbers::pi / 180;

std::vector<CameraPose> track(const SyntheticScene& scene, const std::vector<FramePair>& frames) {
  WorkerPool pool(2);
  TrackedPose tracker(scene.lens, pool);
  std::vector<CameraPose> poses;
  for (const FramePair& frame : frames) poses.push_back(tracker.next(frame.to_previous, frame.from_previous));
  return poses;
}

FlowField clone(const FlowField& flow) { return {flow.vectors.clone(), flow.confidence.clone()}; }

RigidTransform pose_of(const CameraPose& pose) { return pose.T_world_camera; }

double angle_deg(const Eigen::Matrix3d& R) { return Eigen::AngleAxisd(R).angle() / kDegree; }

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0)) / kDegree;
}

// How far the tracked path is from the true one, once they share the unit of length.
struct PathErrors {
  double turn_deg = 0;       // at the last frame
  double direction_deg = 0;  // of the way from first to last
  double worst_step = 0;     // largest |log| change of (tracked step / true step) between neighbouring frames
  double total_drift = 0;    // |log| of that ratio, last frames over first
  std::size_t steps = 0;     // with such a ratio
};

// A camera that stands or only turns keeps its position.
bool has_moved(const std::vector<CameraPose>& tracked, std::size_t i) {
  return i > 0 && (pose_of(tracked[i]).t - pose_of(tracked[i - 1]).t).norm() > 1e-9;
}

PathErrors compare(const std::vector<CameraPose>& tracked, const std::vector<RigidTransform>& truth) {
  PathErrors errors;
  errors.turn_deg = angle_deg(pose_of(tracked.back()).R.transpose() * truth.back().R);
  errors.direction_deg = angle_deg(pose_of(tracked.back()).t, truth.back().t);
  std::vector<double> ratio;
  for (std::size_t i = 1; i < tracked.size(); ++i) {
    if (!has_moved(tracked, i) || !has_moved(tracked, i - 1)) continue;
    ratio.push_back((pose_of(tracked[i]).t - pose_of(tracked[i - 1]).t).norm() /
                    (truth[i].t - truth[i - 1].t).norm());
  }
  for (std::size_t i = 1; i < ratio.size(); ++i)
    errors.worst_step = std::max(errors.worst_step, std::abs(std::log(ratio[i] / ratio[i - 1])));
  errors.steps = ratio.size();
  if (!ratio.empty()) errors.total_drift = std::abs(std::log(ratio.back() / ratio.front()));
  return errors;
}

SyntheticScene room() {
  SyntheticScene scene;
  scene.spheres = {{{-1.5, 0, 4}, 0.8}, {{1.2, -0.4, 3}, 0.5}};
  return scene;
}

}  // namespace

TEST_CASE("a camera that does not move stays exactly where it was", "[pose]") {
  const SyntheticScene scene = room();
  const auto poses = track(scene, film(scene, straight_path(12, {0, 0, 0}, {0, 0, 0}), 0.05));
  for (const CameraPose& pose : poses) {
    CHECK(pose.T_world_camera == RigidTransform());
    CHECK_FALSE(pose.lost);
  }
}

TEST_CASE("a motion too slow for one frame is seen once it has added up", "[pose]") {
  const SyntheticScene scene = room();
  const auto truth = straight_path(20, {0, 0, 0}, {0, 0.0005, 0});  // 0.075 px per frame
  const auto poses = track(scene, film(scene, truth, 0));
  CHECK(angle_deg(pose_of(poses.back()).R.transpose() * truth.back().R) < 0.4 / 150 / kDegree);
}

TEST_CASE("a camera that only turns keeps its position exactly", "[pose]") {
  const SyntheticScene scene = room();
  const auto truth = straight_path(15, {0, 0, 0}, {0.002, 0.012, 0.001});
  const auto poses = track(scene, film(scene, truth, 0.3));
  for (std::size_t i = 1; i < poses.size(); ++i) {
    CHECK(pose_of(poses[i]).R != pose_of(poses[i - 1]).R);
    CHECK(pose_of(poses[i]).t.norm() < 1e-12);
    CHECK(angle_deg(pose_of(poses[i]).R.transpose() * truth[i].R) < 0.15);
  }
}

TEST_CASE("what flow gathers over a long pan is no parallax", "[pose]") {
  const SyntheticScene scene = room();
  std::vector<FramePair> frames = film(scene, straight_path(25, {0, 0, 0}, {0, 0.012, 0}), 0);
  for (FramePair& frame : frames) {  // some rows run ahead, others stay behind, by up to seven percent
    Image<float>& flow = frame.from_previous.vectors;
    for (int y = 0; y < flow.rows(); ++y)
      for (int x = 0; x < flow.cols(); ++x)
        flow.at(0, y, x) *=
            1 + 0.07f * std::sin(6.28f * static_cast<float>(y) / static_cast<float>(flow.rows()));
  }
  for (const CameraPose& pose : track(scene, frames)) CHECK(pose_of(pose).t.norm() < 1e-12);
}

TEST_CASE("a translation is found, whichever way it goes", "[pose]") {
  const SyntheticScene scene = room();
  const auto step = GENERATE(Eigen::Vector3d{0.05, 0, 0}, Eigen::Vector3d{0, -0.05, 0},
                             Eigen::Vector3d{0, 0, 0.08}, Eigen::Vector3d{-0.03, 0.01, -0.05});
  CAPTURE(step.transpose());
  const auto truth = straight_path(15, step, {0.001, -0.003, 0.001});
  const auto poses = track(scene, film(scene, truth, 0.3));
  const PathErrors errors = compare(poses, truth);
  CHECK(has_moved(poses, poses.size() - 1));
  CHECK(errors.turn_deg < 0.5);
  CHECK(errors.direction_deg < 6);
}

TEST_CASE("objects that move by themselves over 30 percent of the picture do not pull the camera along",
          "[pose]") {
  SyntheticScene scene = room();
  scene.spheres.push_back({{-0.6, 0.1, 2.2}, 0.47, {0, 0.02, 0.01}});
  scene.spheres.push_back({{0.8, -0.3, 2.6}, 0.52, {0.01, -0.03, 0}});
  REQUIRE(scene.dynamic_share() > 0.3);
  const auto truth = straight_path(15, {0.05, 0, 0.02}, {0, -0.004, 0});
  const auto poses = track(scene, film(scene, truth, 0.1));
  const PathErrors errors = compare(poses, truth);
  CHECK(errors.turn_deg < 0.25);
  CHECK(errors.direction_deg < 2);
}

TEST_CASE("objects that cross the picture slowly do not take the pose with them", "[pose]") {
  SyntheticScene scene = room();
  scene.spheres.push_back({{-1.6, 0.1, 2.4}, 0.55, {0.03, 0, 0.003}});
  scene.spheres.push_back({{1.6, -0.3, 2.6}, 0.55, {0, -0.03, 0}});
  const auto truth = straight_path(40, {0.02, 0, 0.01}, {0, -0.003, 0});
  double turn_deg = 0, direction_deg = 0;
  constexpr unsigned kSeeds = 4;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const PathErrors errors = compare(track(scene, film(scene, truth, 0.2, seed)), truth);
    turn_deg += errors.turn_deg / kSeeds, direction_deg += errors.direction_deg / kSeeds;
  }
  CHECK(turn_deg < 1.3);
  CHECK(direction_deg < 2.1);
}

TEST_CASE("the scale does not jump over sixty frames", "[pose]") {
  const SyntheticScene scene = room();
  const auto truth = straight_path(60, {0.04, 0.005, 0.02}, {0, -0.004, 0});
  const auto poses = track(scene, film(scene, truth, 0.1));
  const PathErrors errors = compare(poses, truth);
  CHECK(errors.steps > 30);  // a camera that is said to stand has no scale at all
  CHECK(errors.worst_step < 0.1);
  CHECK(errors.total_drift < 0.08);
  CHECK(errors.turn_deg < 0.4);
}

TEST_CASE("a flat scene is no reason to lose the rotation", "[pose]") {
  SyntheticScene scene;
  scene.relief = false;
  const auto truth = straight_path(15, {0.05, 0, 0}, {0, 0.002, 0.002});
  const auto poses = track(scene, film(scene, truth, 0.1));
  for (const CameraPose& pose : poses) REQUIRE(pose.T_world_camera.finite());
  // a plane seen head-on cannot tell a sideways step (0.05 / 7 rad per frame) from a turn: no worse than that
  CHECK(angle_deg(pose_of(poses.back()).R.transpose() * truth.back().R) < 14 * 0.05 / 7 / kDegree * 1.2);
}

TEST_CASE("a tiny baseline makes no large step", "[pose]") {
  const SyntheticScene scene = room();
  const auto truth = straight_path(10, {0.0008, 0, 0}, {0.003, 0, 0});
  const auto poses = track(scene, film(scene, truth, 0.3));
  for (const CameraPose& pose : poses) {
    CHECK(pose.T_world_camera.finite());
    CHECK(pose_of(pose).t.norm() < 0.02);
  }
}

TEST_CASE("the same flow gives the same bytes", "[pose]") {
  const SyntheticScene scene = room();
  const auto frames = film(scene, straight_path(10, {0.05, 0, 0.02}, {0, 0.003, 0}), 0.3);
  const auto first = track(scene, frames), second = track(scene, frames);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CHECK(first[i].T_world_camera == second[i].T_world_camera);
  }
}

TEST_CASE("a frame that shows nothing continues the motion, and the scale survives it", "[pose]") {
  const SyntheticScene scene = room();
  const auto truth = straight_path(24, {0.05, 0, 0.01}, {0, -0.003, 0});
  auto frames = film(scene, truth, 0.1);
  for (const std::size_t dark : {12u, 13u}) {
    frames[dark].to_previous.confidence.fill(0);
    frames[dark].from_previous.confidence.fill(0);
  }
  const auto poses = track(scene, frames);
  CHECK(poses[12].lost);
  CHECK(poses[13].lost);
  CHECK_FALSE(poses[14].lost);
  const Eigen::Vector3d before = pose_of(poses[11]).t - pose_of(poses[10]).t;
  CHECK((pose_of(poses[12]).t - pose_of(poses[11]).t).norm() == Approx(before.norm()).epsilon(0.2));
  const double scale_before = pose_of(poses[11]).t.norm() / truth[11].t.norm();
  const double scale_after =
      (pose_of(poses[23]).t - pose_of(poses[14]).t).norm() / (truth[23].t - truth[14].t).norm();
  CHECK(scale_after / scale_before == Approx(1).margin(0.25));
}

TEST_CASE("the scale survives any time that the camera stands still", "[pose]") {
  SyntheticScene scene;
  scene.spheres = {{{-1.5, 0, 4.8}, 0.5}, {{1.2, -0.4, 5}, 0.5}};
  constexpr std::size_t kForward = 40, kStands = 130, kSideways = 30;
  std::vector<RigidTransform> truth(1);
  const auto go = [&](std::size_t frames, const Eigen::Vector3d& step) {
    for (std::size_t i = 0; i < frames; ++i) {
      RigidTransform next = truth.back();
      next.t += step;
      truth.push_back(next);
    }
  };
  go(kForward, {0.06, 0, 0.07}), go(kStands, {0, 0, 0}), go(kSideways, {-0.08, 0, 0});
  const auto poses = track(scene, film(scene, truth, 0.05));
  const auto unit = [&](std::size_t from, std::size_t to) {
    return (pose_of(poses[to]).t - pose_of(poses[from]).t).norm() / (truth[to].t - truth[from].t).norm();
  };
  const std::size_t last = truth.size() - 1;
  CHECK(unit(last - 20, last) / unit(kForward / 2, kForward) == Approx(1).margin(0.1));
}

TEST_CASE("a frame that is lost right after the first translation goes no further than the camera did",
          "[pose]") {
  const SyntheticScene scene = room();
  const Eigen::Vector3d step{0.02, 0, 0.01};
  const auto truth = straight_path(40, step, {0, 0.004, 0});
  auto frames = film(scene, truth, 0.03);
  const auto poses = track(scene, frames);
  std::size_t first = 0;
  while (first < poses.size() && !has_moved(poses, first)) ++first;
  REQUIRE(first + 1 < poses.size());
  frames[first + 1].to_previous.confidence.fill(0);
  frames[first + 1].from_previous.confidence.fill(0);
  const auto again = track(scene, frames);
  REQUIRE(again[first + 1].lost);
  const RigidTransform moved = pose_of(again[first]).inverse() * pose_of(again[first + 1]);
  const double unit = pose_of(again[first]).t.norm() / truth[first].t.norm();
  CHECK(moved.t.norm() / unit < 1.1 * step.norm());  // its position has caught up: that is no velocity
}

TEST_CASE("nothing to see from the start on is lost, not NaN", "[pose]") {
  const SyntheticScene scene = room();
  auto frames = film(scene, straight_path(5, {0.05, 0, 0}, {0, 0, 0}), 0);
  for (FramePair& frame : frames) frame.from_previous.confidence.fill(0);
  const auto poses = track(scene, frames);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    CHECK(poses[i].lost);
    CHECK(poses[i].T_world_camera.finite());
  }
}

TEST_CASE("flow that is not finite is ignored", "[pose]") {
  const SyntheticScene scene = room();
  const auto truth = straight_path(10, {0.05, 0, 0}, {0, 0.002, 0});
  auto frames = film(scene, truth, 0);
  for (std::size_t i = 1; i < frames.size(); ++i)
    for (std::size_t k = 0; k < frames[i].from_previous.vectors.size(); k += 3)
      frames[i].from_previous.vectors.samples()[k] = i % 2 ? NAN : INFINITY;
  for (const CameraPose& pose : track(scene, frames)) CHECK(pose.T_world_camera.finite());
}

TEST_CASE("a focal length that is wrong by 10 percent costs accuracy, not the track", "[pose]") {
  SyntheticScene scene = room();
  const auto truth = straight_path(15, {0.05, 0, 0.03}, {0, -0.003, 0});
  const auto frames = film(scene, truth, 0.1);
  const double factor = GENERATE(0.9, 1.1);
  scene.lens.fx_px *= factor, scene.lens.fy_px *= factor;
  const auto poses = track(scene, frames);
  const PathErrors errors = compare(poses, truth);
  CHECK_FALSE(poses.back().lost);
  CHECK(errors.turn_deg < 0.6);
  CHECK(errors.direction_deg < 6);
}

TEST_CASE(
    "of frames that show nothing a cycle has some, and in a row they are no way to see where a camera goes",
    "[pose]") {
  const SyntheticScene scene = room();
  const auto path = straight_path(40, {0.05, 0, 0}, {0, 0.002, 0});
  const std::vector<FramePair> flows = film(scene, path, 0);
  const auto lost_among = [&](const auto& is_black, float code) {
    WorkerPool pool(1);
    TrackedPose tracker(scene.lens, pool);
    const RadianceState state;
    ExposedFrame frame;
    frame.codes = Image<float>(3, scene.rows, scene.cols);
    std::vector<int> lost;
    for (std::size_t i = 0; i < flows.size(); ++i) {
      frame.codes.fill(is_black(static_cast<int>(i)) ? code : 128.f);
      const StateMotion motion{clone(flows[i].to_previous), clone(flows[i].from_previous)};
      if (tracker.estimate({frame, state, motion}).lost) lost.push_back(static_cast<int>(i));
    }
    return lost;
  };
  for (const float code : {0.f, 255.f}) {
    CHECK(lost_among([](int i) { return i % 4 != 0; }, code).empty());
    const std::vector<int> lost = lost_among([](int i) { return i >= 20; }, code);
    REQUIRE(lost.size() == 16);
    CHECK(lost.front() == 24);
  }
}

TEST_CASE("a camera that does not say its lens is assumed to see 55 degrees", "[pose]") {
  const Intrinsics lens = assumed_intrinsics(240, 320);
  CHECK(2 * std::atan(lens.cx_px / lens.fx_px) / kDegree == Approx(55));
  CHECK(lens.fx_px == lens.fy_px);
  CHECK(lens.cy_px == 120);
}
