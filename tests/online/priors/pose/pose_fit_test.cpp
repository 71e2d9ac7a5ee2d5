#include "online/priors/pose/pose_fit.h"

#include <catch2/catch.hpp>
#include <random>

#include "online/priors/pose/heading_search.h"

using namespace hdrcam;

namespace {

const Intrinsics kLens{300, 300, 160, 120};
const RigidTransform kTruth{rotation({0.01, -0.02, 0.005}), {0.06, -0.02, 0.04}};  // T_camera_world

// Points first seen from the origin, depths 1..5, seen again from kTruth; every `outliers`-th is somewhere
// else.
std::vector<ScenePoint> scene(double prior_error, int outliers, std::vector<double>& depths) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(-0.5, 0.5), y(-0.4, 0.4), inverse(0.2, 1), any(-20, 20);
  std::vector<ScenePoint> points;
  for (int i = 0; i < 300; ++i) {
    ScenePoint p;
    p.origin_world = {0, 0, 0};
    p.direction_world = {x(random), y(random), 1};
    depths.push_back(inverse(random));
    const Eigen::Vector3d q = kTruth.R * p.direction_world + depths.back() * kTruth.t;
    p.seen_px = {kLens.fx_px * q.x() / q.z() + kLens.cx_px, kLens.fy_px * q.y() / q.z() + kLens.cy_px};
    if (outliers > 0 && i % outliers == 0) p.seen_px += Eigen::Vector2d(any(random), any(random));
    p.inverse_depth = depths.back() * (1 + prior_error);
    p.information = 1e4;
    p.sigma_px = 0.2;
    points.push_back(p);
  }
  return points;
}

std::vector<double> priors(const std::vector<ScenePoint>& points) {
  std::vector<double> depths;
  for (const ScenePoint& p : points) depths.push_back(p.inverse_depth);
  return depths;
}

PoseFit fit_pose(const std::vector<ScenePoint>& points, const RigidTransform& start,
                 const FitOptions& options, std::vector<double>& depths, int threads = 2) {
  WorkerPool pool(threads);
  return PoseFitter(pool).fit(points, kLens, start, options, depths);
}

// The headings of points of which no depth is known.
std::vector<Heading> headings_of(std::vector<ScenePoint> points, int count) {
  for (ScenePoint& p : points) p.inverse_depth = 1, p.information = 0.01;
  auto depths = priors(points);
  const PoseFit turned = fit_pose(points, {}, {.freedom = Freedom::Rotation}, depths);
  return search_headings(points, kLens, turned.T_camera_world, count);
}

}  // namespace

TEST_CASE("known depths give the pose with its scale, outliers or not", "[pose]") {
  const int outliers = GENERATE(0, 3);
  std::vector<double> truth;
  const auto points = scene(0, outliers, truth);
  auto depths = priors(points);
  const PoseFit fit = fit_pose(points, {}, {.steps = 12}, depths);
  CHECK((fit.T_camera_world.R - kTruth.R).norm() < 1e-4);
  CHECK((fit.T_camera_world.t - kTruth.t).norm() < 1e-4);
  CHECK(fit.inlier_share > (outliers > 0 ? 0.6 : 0.99));
}

TEST_CASE("the scale is that of the depths: all a tenth nearer, the step a tenth shorter", "[pose]") {
  std::vector<double> truth;
  const auto points = scene(0.1, 0, truth);
  auto depths = priors(points);
  const PoseFit fit = fit_pose(points, {}, {.steps = 12}, depths);
  CHECK(fit.T_camera_world.t.norm() * 1.1 == Approx(kTruth.t.norm()).epsilon(0.01));
}

TEST_CASE("a pose and its depths are the same for any number of threads", "[pose]") {
  std::vector<double> truth;
  const auto points = scene(0.02, 3, truth);
  auto depths = priors(points), by_three = depths;
  const PoseFit fit = fit_pose(points, {}, {}, depths, 1), other = fit_pose(points, {}, {}, by_three, 3);
  CHECK(fit.T_camera_world.R == other.T_camera_world.R);
  CHECK(fit.T_camera_world.t == other.T_camera_world.t);
  CHECK(fit.cost == other.cost);
  CHECK(depths == by_three);
}

TEST_CASE("a pose is fitted to all of its points, to the last", "[pose]") {
  std::vector<double> truth;
  auto points = scene(0, 0, truth);
  for (std::size_t i = 0; i + 4 < points.size(); ++i) points[i].seen = false;  // three and more are needed
  auto depths = priors(points);
  const PoseFit fit = fit_pose(points, {}, {.steps = 20}, depths);
  CHECK(fit.seen == 4);
  CHECK((fit.T_camera_world.t - kTruth.t).norm() < 1e-3);
}

TEST_CASE("depths that nobody knew are fitted with the pose", "[pose]") {
  std::vector<double> truth;
  auto points = scene(0, 0, truth);
  for (std::size_t i = 0; i < points.size(); i += 2)
    points[i].inverse_depth = 0.5, points[i].information = 1e-3;
  auto depths = priors(points);
  fit_pose(points, {}, {.steps = 12}, depths);
  double off = 0;
  for (std::size_t i = 0; i < points.size(); i += 2) off = std::max(off, std::abs(depths[i] - truth[i]));
  CHECK(off < 1e-2);
}

TEST_CASE("a rotation without a translation keeps the camera's centre", "[pose]") {
  std::vector<double> truth;
  const auto points = scene(0, 0, truth);
  auto depths = priors(points);
  const RigidTransform start{rotation({0, 0.01, 0}), {0.3, 0.2, -0.1}};
  const PoseFit fit = fit_pose(points, start, {.freedom = Freedom::Rotation}, depths);
  CHECK((fit.T_camera_world.inverse().t - start.inverse().t).norm() < 1e-9);
}

TEST_CASE("nothing seen leaves the pose as it was", "[pose]") {
  std::vector<double> truth;
  auto points = scene(0, 0, truth);
  for (ScenePoint& p : points) p.seen = false;
  auto depths = priors(points);
  const RigidTransform start{rotation({0, 0.01, 0}), {0.3, 0.2, -0.1}};
  const PoseFit fit = fit_pose(points, start, {}, depths);
  CHECK(fit.seen == 0);
  CHECK((fit.T_camera_world.R - start.R).norm() < 1e-9);
  CHECK((fit.T_camera_world.t - start.t).norm() < 1e-9);
}

TEST_CASE("the heading is found without any depth", "[pose]") {
  std::vector<double> truth;
  auto points = scene(0, 4, truth);
  const auto headings = headings_of(std::move(points), 4);
  REQUIRE(headings.size() >= 4);
  double best = -1;
  for (const Heading& heading : headings)
    best = std::max(best, heading.T_camera_world.t.normalized().dot(kTruth.t.normalized()));
  CHECK(best > 0.9);
}

TEST_CASE("behind a sideways heading stands its opposite, near for far", "[pose]") {
  std::vector<double> truth;
  auto points = scene(0, 0, truth);
  auto headings = headings_of(std::move(points), 1);
  REQUIRE(headings.size() == 2);
  const auto along_truth = [](const Heading& heading) {
    return heading.T_camera_world.t.normalized().dot(kTruth.t.normalized());
  };
  if (along_truth(headings[0]) < 0) std::swap(headings[0], headings[1]);
  CHECK(along_truth(headings[0]) > 0.9);
  CHECK(along_truth(headings[1]) < -0.9);
  const auto depth_order = [&](const Heading& heading) {  // > 0: as the truth has it
    double sum = 0;
    for (std::size_t i = 1; i < truth.size(); ++i)
      sum += (truth[i] - truth[i - 1]) * (heading.inverse_depths[i] - heading.inverse_depths[i - 1]);
    return sum;
  };
  CHECK(depth_order(headings[0]) > 0);
  CHECK(depth_order(headings[1]) < 0);
}
