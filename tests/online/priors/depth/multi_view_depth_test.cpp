#include "online/priors/depth/multi_view_depth.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <tuple>

#include "tests/online/priors/pose/synthetic_scene.h"
#include "tests/support/uniform_flow.h"

using namespace hdrcam;
using namespace hdrcam::test;

namespace {

SyntheticScene room() {
  SyntheticScene scene;
  scene.spheres = {{{-1.5, 0, 4}, 0.8}};
  return scene;
}

CameraPose at(const RigidTransform& T_world_camera, bool lost = false) {
  CameraPose pose;
  pose.T_world_camera = T_world_camera;
  pose.lost = lost;
  return pose;
}

DepthMap run(const SyntheticScene& scene, const std::vector<RigidTransform>& path,
             const std::vector<FramePair>& frames, const DepthOptions& options, int threads = 1) {
  WorkerPool pool(threads);
  MultiViewDepth depth(options, scene.lens, scene.rows, scene.cols, pool);
  const DepthMap* prior = nullptr;
  for (std::size_t i = 0; i < path.size(); ++i) prior = &depth.next(at(path[i]), frames[i].to_previous);
  return {prior->inverse_depth.clone(), prior->weight.clone()};
}

struct Quality {
  double dense = 0, relative_error = 0, dynamic_kept = 0;
};

Quality judge(const SyntheticScene& scene, const RigidTransform& T_world_camera, double time,
              const DepthMap& prior, int step_px, int dynamic_sphere = -1) {
  int known = 0, all = 0, dynamic = 0, dynamic_kept = 0;
  double error = 0;
  for (int y = 0; y < prior.weight.rows(); ++y)
    for (int x = 0; x < prior.weight.cols(); ++x) {
      const double u = x * step_px + step_px / 2 + 0.5, v = y * step_px + step_px / 2 + 0.5;
      const auto hit = scene.cast(T_world_camera, time, u, v);
      const bool believed = prior.weight.at(0, y, x) > 0.8f;
      if (hit.sphere >= 0 && hit.sphere == dynamic_sphere) {
        ++dynamic, dynamic_kept += believed;
        continue;
      }
      ++all;
      if (!believed) continue;
      ++known;
      error += std::min(1.0, std::abs(hit.depth * static_cast<double>(prior.inverse_depth.at(0, y, x)) - 1));
    }
  return {static_cast<double>(known) / all, known > 0 ? error / known : 0,
          dynamic > 0 ? static_cast<double>(dynamic_kept) / dynamic : 0};
}

}  // namespace

TEST_CASE("the depth of a static scene is found at nearly every pixel", "[depth]") {
  const SyntheticScene scene = room();
  const auto path = straight_path(16, {0.05, 0, 0.02}, {0, -0.003, 0});
  const int step_px = GENERATE(1, 2);
  const DepthMap prior = run(scene, path, film(scene, path, 0.1), {.step_px = step_px});
  CHECK(prior.weight.cols() == scene.cols / step_px);
  const Quality quality = judge(scene, path.back(), 15, prior, step_px);
  CHECK(quality.dense > 0.6);
  CHECK(quality.relative_error < 0.03);
}

TEST_CASE("more views make it better", "[depth]") {
  const SyntheticScene scene = room();
  const auto path = straight_path(20, {0.03, 0, 0}, {0, 0, 0});
  const auto frames = film(scene, path, 0.2);
  const auto first = [&](std::size_t n) {
    const std::vector<RigidTransform> some(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(n));
    return judge(scene, some.back(), static_cast<double>(n - 1), run(scene, some, frames, {}), 2);
  };
  const Quality few = first(4), many = first(20);
  CHECK(many.relative_error < few.relative_error);
  CHECK(many.dense > 0.8);
}

TEST_CASE("what moves across its epipolar line is not believed", "[depth]") {
  SyntheticScene scene = room();
  scene.spheres.push_back({{0.5, -0.2, 3}, 0.6, {0, 0.04, 0}});
  const auto path = straight_path(12, {0.05, 0, 0}, {0, 0, 0});
  const DepthMap prior = run(scene, path, film(scene, path, 0.05), {});
  const Quality quality = judge(scene, path.back(), 11, prior, 2, 1);
  CHECK(quality.dynamic_kept < 0.1);
  CHECK(quality.dense > 0.6);
}

TEST_CASE("what begins to move loses the depth that it had", "[depth]") {
  const Eigen::Vector3d start{0.9, -0.2, 3}, velocity{0, 0.03, 0};
  constexpr std::size_t kAtRest = 17;  // frames: keyframes have been replaced, and their depth is learnt
  SyntheticScene rests = room(), moves = room();
  rests.spheres.push_back({start, 0.6});
  moves.spheres.push_back({start - velocity * static_cast<double>(kAtRest - 1), 0.6, velocity});
  const auto path = straight_path(24, {0.05, 0, 0}, {0, 0, 0});
  auto frames = film(rests, path, 0.05);
  const DepthMap before = run(rests, {path.begin(), path.begin() + kAtRest}, frames, {});
  CHECK(judge(rests, path[kAtRest - 1], 0, before, 2, 1).dynamic_kept > 0.8);
  auto later = film(moves, path, 0.05);
  std::move(later.begin() + kAtRest, later.end(), frames.begin() + kAtRest);
  const DepthMap after = run(moves, path, frames, {});
  CHECK(judge(moves, path.back(), 23, after, 2, 1).dynamic_kept < 0.1);
  CHECK(judge(moves, path.back(), 23, after, 2, 1).dense > 0.6);
}

TEST_CASE("a camera that stands still or turns learns no depth", "[depth]") {
  const SyntheticScene scene = room();
  const auto turn = GENERATE(Eigen::Vector3d{0, 0, 0}, Eigen::Vector3d{0, 0.01, 0});
  const auto path = straight_path(8, {0, 0, 0}, turn);
  const DepthMap prior = run(scene, path, film(scene, path, 0.1), {});
  for (const float w : prior.weight.samples()) REQUIRE(w == 0);
}

TEST_CASE("what was learnt stays while the camera stops", "[depth]") {
  const SyntheticScene scene = room();
  auto path = straight_path(14, {0.05, 0, 0}, {0, 0, 0});
  const int still = GENERATE(20, 250);
  for (int i = 0; i < still; ++i) path.push_back(path.back());
  const DepthMap prior = run(scene, path, film(scene, path, 0), {});
  const Quality quality = judge(scene, path.back(), static_cast<double>(path.size() - 1), prior, 2);
  CHECK(quality.dense > 0.5);
  CHECK(quality.relative_error < 0.01);
}

TEST_CASE("the depth does not depend on the number of threads", "[depth]") {
  const SyntheticScene scene = room();
  const auto path = straight_path(10, {0.05, 0, 0.02}, {0, -0.003, 0});
  const auto frames = film(scene, path, 0.2);
  const DepthMap one = run(scene, path, frames, {}, 1), three = run(scene, path, frames, {}, 3);
  CHECK(std::memcmp(one.inverse_depth.plane(0), three.inverse_depth.plane(0),
                    one.inverse_depth.size() * sizeof(float)) == 0);
  CHECK(std::memcmp(one.weight.plane(0), three.weight.plane(0), one.weight.size() * sizeof(float)) == 0);
}

TEST_CASE("every point of the grid stands for a pixel of the picture, however small that is", "[depth]") {
  const auto [rows, cols, step] =
      GENERATE(std::tuple(2, 64, 2), std::tuple(6, 64, 4), std::tuple(1, 1, 2), std::tuple(24, 17, 16));
  CAPTURE(rows, cols, step);
  WorkerPool pool(1);
  DepthOptions options;
  options.step_px = step;
  MultiViewDepth depth(options, {64, 64, cols / 2.0, rows / 2.0}, rows, cols, pool);
  const FlowField flow = uniform_flow(rows, cols, 0.5f, 0.5f);
  RigidTransform T_world_camera;
  for (int i = 0; i < 4; ++i) {
    T_world_camera.t.x() = 0.1 * i;
    const DepthMap& map = depth.next(at(T_world_camera), flow);
    CHECK(map.step_px == step);
    for (int y = 0; y < map.weight.rows(); ++y) CHECK(map.pixel_of(y, rows) < rows);
    for (int x = 0; x < map.weight.cols(); ++x) CHECK(map.pixel_of(x, cols) < cols);
    for (const float d : map.inverse_depth.samples()) CHECK(std::isfinite(d));
  }
}

TEST_CASE("a lost pose forgets, broken flow is not believed, and nothing is ever NaN", "[depth]") {
  const SyntheticScene scene = room();
  const auto path = straight_path(8, {0.05, 0, 0}, {0, 0, 0});
  auto frames = film(scene, path, 0);
  for (std::size_t k = 0; k < frames[5].to_previous.vectors.size(); k += 5)
    frames[5].to_previous.vectors.samples()[k] = NAN;
  WorkerPool pool(1);
  MultiViewDepth depth({}, scene.lens, scene.rows, scene.cols, pool);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const DepthMap& prior = depth.next(at(path[i], i == 7), frames[i].to_previous);
    for (const float d : prior.inverse_depth.samples()) REQUIRE((std::isfinite(d) && d >= 0));
    for (const float w : prior.weight.samples()) REQUIRE((w >= 0 && w <= 1));
    if (i == 7)
      REQUIRE(std::all_of(prior.weight.samples().begin(), prior.weight.samples().end(),
                          [](float w) { return w == 0; }));
  }
}
