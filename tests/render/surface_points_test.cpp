#include "render/surface_points.h"

#include <cmath>

#include "tests/support/state_estimate.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 32, kCols = 48, kStep = 2;
constexpr float kSurelyKnown = 0.995f;  // weight of a depth that is known to a fourteenth

// A wall at a depth of 4 before a camera that looks along the world's x, 10 of its units up.
struct Wall {
  ExposedFrame input;
  RadianceEstimate state;
  Image<float> own_share, radiance{3, kRows, kCols};
  DepthMap depth{Image<float>(1, kRows / kStep, kCols / kStep), Image<float>(1, kRows / kStep, kCols / kStep),
                 kStep};
  FramePose pose;
  std::vector<SurfacePoint> points = std::vector<SurfacePoint>(7);  // of an earlier frame

  Wall() {
    depth.inverse_depth.fill(0.25f), depth.weight.fill(kSurelyKnown);
    pose.T_world_camera = {rotation({0, std::acos(0.0), 0}), {0, -10, 0}};
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) radiance.at(c, y, x) = static_cast<float>(10000 * c + 100 * y + x);
  }
  void find(bool posed = true) {
    FrameEstimate estimate = test::estimate_by_state(input, state, own_share);
    estimate.view.rows = kRows, estimate.view.cols = kCols;
    estimate.view.lens = {50, 40, 24, 16};
    if (posed) estimate.pose = pose;
    estimate.depth = &depth;
    find_surface_points(estimate, radiance, points);
  }
};

}  // namespace

TEST_CASE("every eighth pixel whose depth is known to a tenth is a point of the world, with its light") {
  Wall wall;
  wall.depth.weight.at(0, 2, 6) = 1 / (1 + 0.11f * 0.11f);  // known to 11 percent: that of pixel 13, 5
  wall.depth.weight.at(0, 2, 10) = 1 / (1 + 0.09f * 0.09f);
  wall.depth.inverse_depth.at(0, 6, 2) = 0;  // that of pixel 5, 13: nowhere
  wall.find();
  REQUIRE(wall.points.size() == kRows / 8 * (kCols / 8) - 2);
  bool nearly_unknown = false;
  for (const SurfacePoint& point : wall.points) {
    CAPTURE(point.u_px, point.v_px);
    CHECK(std::fmod(point.u_px, 8) == 5.5);
    CHECK(std::fmod(point.v_px, 8) == 5.5);
    const bool left_out =
        (point.u_px == 13.5 && point.v_px == 5.5) || (point.u_px == 5.5 && point.v_px == 13.5);
    CHECK_FALSE(left_out);
    nearly_unknown = nearly_unknown || (point.u_px == 21.5 && point.v_px == 5.5);
    // the camera's z is the world's x, its x the world's -z
    CHECK(point.p_world.x() == Approx(4));
    CHECK(point.p_world.y() == Approx(-10 + (point.v_px - 16) / 40 * 4));
    CHECK(point.p_world.z() == Approx(-(point.u_px - 24) / 50 * 4).margin(1e-9));
    for (std::size_t c = 0; c < 3; ++c)
      CHECK(static_cast<double>(point.radiance[c]) ==
            10000 * static_cast<double>(c) + 100 * (point.v_px - 0.5) + point.u_px - 0.5);
  }
  CHECK(nearly_unknown);
}

TEST_CASE("a frame that does not know where it is has no points, and none of the one before") {
  Wall wall;
  wall.find(false);
  CHECK(wall.points.empty());
  wall.find();
  CHECK_FALSE(wall.points.empty());
  wall.pose.lost = true;
  wall.find();
  CHECK(wall.points.empty());
}
