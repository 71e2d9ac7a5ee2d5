#include "online/priors/depth/dynamic_depth.h"

#include <algorithm>
#include <functional>
#include <vector>

#include "tests/online/priors/pose/synthetic_scene.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace hdrcam::test;

namespace {

constexpr int kRows = 60, kCols = 80, kStep = 2;
constexpr float kWall = 0.2f;

struct Rect {
  int y0, y1, x0, x1;  // on the grid, ends excluded
  bool holds(int y, int x) const { return y >= y0 && y < y1 && x >= x0 && x < x1; }
};

// Measured everywhere but where something moves.
struct Seen {
  DepthMap measured{Image<float>(1, kRows, kCols), Image<float>(1, kRows, kCols), kStep};
  Image<float> dynamic{1, kRows, kCols};

  explicit Seen(const Rect& rect, const std::function<float(int)>& inverse_depth_of_row) {
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        const bool moves = rect.holds(y, x);
        dynamic.at(0, y, x) = moves;
        measured.inverse_depth.at(0, y, x) = moves ? 0 : inverse_depth_of_row(y);
        measured.weight.at(0, y, x) = moves ? 0 : 0.95f;
      }
  }
};

float wall(int) { return kWall; }

struct Completed {
  WorkerPool pool{1};
  DynamicDepth depth;
  explicit Completed(const DynamicDepthOptions& options = {})
      : depth({.step_px = kStep}, options, {160, 160, 80, 60}, kRows * kStep, kCols * kStep, pool) {}
  const DepthMap& operator()(const Seen& seen, const FlowField& to_previous = {}) {
    return depth.complete(seen.measured, seen.dynamic, to_previous);
  }
};

FlowField at_rest() { return uniform_flow(kRows * kStep, kCols * kStep); }

}  // namespace

TEST_CASE("what moves before a wall is guessed at half of the wall's distance, and weighs as a guess",
          "[depth]") {
  Completed completed;
  const DepthMap& map = completed(Seen({20, 40, 30, 45}, wall));
  CHECK(map.inverse_depth.at(0, 30, 37) == Approx(2 * kWall));
  CHECK(map.weight.at(0, 30, 37) > 0.5f);
  CHECK(map.weight.at(0, 30, 37) < 0.8f);
  CHECK(map.inverse_depth.at(0, 30, 10) == Approx(kWall));
  CHECK(map.weight.at(0, 30, 10) == 0.95f);
}

TEST_CASE("what moves on ground is where the ground is that it stands on", "[depth]") {
  constexpr int kHorizon = 15, kFeet = 44;
  const auto street = [](int y) { return std::max(0.05f, 0.012f * static_cast<float>(y - kHorizon)); };
  Completed completed;
  const DepthMap& map = completed(Seen({18, kFeet, 30, 45}, street));
  CHECK(map.inverse_depth.at(0, 30, 37) == Approx(street(kFeet)).epsilon(0.25));
}

TEST_CASE("a few points that move, and some among many that do not, are no region", "[depth]") {
  Completed completed;
  Seen seen({20, 23, 30, 33}, wall);
  for (int y = 40; y < 60; y += 3)
    for (int x = 40; x < 60; x += 3) seen.dynamic.at(0, y, x) = 1, seen.measured.weight.at(0, y, x) = 0;
  const DepthMap& map = completed(seen);
  CHECK(map.weight.at(0, 21, 31) == 0);
  CHECK(map.weight.at(0, 49, 49) == 0);
}

TEST_CASE("a region without anything measured around it is not guessed", "[depth]") {
  Completed completed;
  Seen seen({20, 40, 30, 45}, wall);
  seen.measured.weight.fill(0);
  const DepthMap& map = completed(seen);
  for (const float weight : map.weight.samples()) REQUIRE(weight == 0);
}

TEST_CASE("the guess follows what is around a region slowly", "[depth]") {
  Completed completed;
  const Rect rect{20, 40, 30, 45};
  completed(Seen(rect, wall));
  const auto nearer_wall = [](int) { return 2 * kWall; };
  const float second = completed(Seen(rect, nearer_wall), at_rest()).inverse_depth.at(0, 30, 37);
  CHECK(second > 2.2f * kWall);
  CHECK(second < 3 * kWall);
  float last = second;
  for (int i = 0; i < 20; ++i)
    last = completed(Seen(rect, nearer_wall), at_rest()).inverse_depth.at(0, 30, 37);
  CHECK(last == Approx(4 * kWall).epsilon(0.02));
}

TEST_CASE("without a guess the measured depth stays as it is", "[depth]") {
  Completed completed({.nearer = 0});
  const Seen seen({20, 40, 30, 45}, wall);
  const DepthMap& map = completed(seen);
  for (std::size_t i = 0; i < map.weight.size(); ++i) {
    REQUIRE(map.weight.samples()[i] == seen.measured.weight.samples()[i]);
    REQUIRE(map.inverse_depth.samples()[i] == seen.measured.inverse_depth.samples()[i]);
  }
}

TEST_CASE("a ball that crosses a room before its walls is put in front of them", "[depth]") {
  SyntheticScene scene;
  scene.spheres = {{{0.5, -0.2, 3}, 0.6, {0, 0.04, 0}}};
  const auto path = straight_path(12, {0.05, 0, 0}, {0, 0, 0});
  const auto frames = film(scene, path, 0.05);
  WorkerPool pool(1);
  DynamicDepth depth({}, {}, scene.lens, scene.rows, scene.cols, pool);
  MultiViewDepth measured({}, scene.lens, scene.rows, scene.cols, pool);
  const DepthMap* map = nullptr;
  for (std::size_t i = 0; i < path.size(); ++i) {
    CameraPose pose;
    pose.T_world_camera = path[i];
    const DepthMap& of_static = measured.next(pose, frames[i].to_previous);
    map = &depth.complete(of_static, measured.dynamic(), frames[i].to_previous);
  }
  int of_ball = 0, guessed = 0;
  std::vector<double> relative;
  for (int y = 0; y < map->weight.rows(); ++y)
    for (int x = 0; x < map->weight.cols(); ++x) {
      const auto hit = scene.cast(path.back(), 11, 2 * x + 1.5, 2 * y + 1.5);
      if (hit.sphere < 0) continue;
      ++of_ball;
      if (map->weight.at(0, y, x) < 0.5f) continue;
      ++guessed;
      relative.push_back(1 / (hit.depth * static_cast<double>(map->inverse_depth.at(0, y, x))));
    }
  CHECK(guessed > 0.9 * of_ball);
  std::nth_element(relative.begin(), relative.begin() + static_cast<std::ptrdiff_t>(relative.size() / 2),
                   relative.end());
  const double middle = relative[relative.size() / 2];  // of the ball's distance
  CHECK(middle > 0.6);
  CHECK(middle < 1.6);
}
