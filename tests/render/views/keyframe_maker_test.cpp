// What a keyframe has besides its picture: depth as the field sees it, and the motion from the one before.
#include "render/views/keyframe_maker.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 64, kCols = 96;
constexpr float kFieldDepth = 8, kStep_px = 3;

class FlatWall final : public FieldSnapshot {
 public:
  void look(const SceneView& view, WorkerPool&, FieldPicture& picture) const override {
    picture.depth.reshape(1, view.rows, view.cols), picture.depth.fill(kFieldDepth);
  }
};

class SlantedWall final : public FieldSnapshot {
 public:
  void look(const SceneView& view, WorkerPool&, FieldPicture& picture) const override {
    picture.depth.reshape(1, view.rows, view.cols);
    for (int y = 0; y < view.rows; ++y)
      for (int x = 0; x < view.cols; ++x)
        picture.depth.at(0, y, x) = kFieldDepth + 0.01f * static_cast<float>(x - view.cols / 2);
  }
};

// A texture that does not repeat itself, moved to the right.
Keyframe texture_at(float moved_px) {
  Keyframe key;
  key.frame.white = 1;
  key.frame.radiance = Image<float>(3, kRows, kCols);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        const float along = static_cast<float>(x) - moved_px, across = static_cast<float>(y);
        key.frame.radiance.at(c, y, x) = 0.3f + 0.12f * std::sin(0.31f * along + 0.17f * across) +
                                         0.12f * std::sin(0.23f * across - 0.11f * along);
      }
  return key;
}

// In the middle of the picture, along x.
double mean_along(const Image<float>& vectors) {
  double sum = 0;
  int count = 0;
  for (int y = 16; y < kRows - 16; ++y)
    for (int x = 16; x < kCols - 16; ++x, ++count) sum += static_cast<double>(vectors.at(0, y, x));
  return sum / count;
}

}  // namespace

TEST_CASE(
    "a keyframe's depth is the field's in the unit of its poses, and the same everywhere without a field") {
  WorkerPool pool(2);
  KeyframeMaker maker(pool);
  const FlatWall wall;
  Keyframe key = texture_at(0);
  key.depth_unit = 0.25f;
  maker.complete(SnapshotHold(wall), nullptr, key);
  REQUIRE(key.inverse_depth.rows() == kRows);
  REQUIRE(key.inverse_depth.cols() == kCols);
  for (const float v : key.inverse_depth.samples())
    REQUIRE(v == Approx(1 / (kFieldDepth * 0.25f)).epsilon(1e-4));
  CHECK(key.to_previous.empty());
  maker.complete(SnapshotHold(), nullptr, key);
  for (const float v : key.inverse_depth.samples()) REQUIRE(v == Approx(1).epsilon(1e-4));
  CHECK_FALSE(key.knows_depth);
}

TEST_CASE("a keyframe of a scene of which no depth is known is one plane, where the field takes it to be") {
  WorkerPool pool(1);
  KeyframeMaker maker(pool);
  const SlantedWall wall;
  Keyframe key = texture_at(0);
  key.depth_unit = 0.25f, key.knows_depth = false;
  maker.complete(SnapshotHold(wall), nullptr, key);
  const float plane = key.inverse_depth.at(0, 0, 0);
  CHECK(plane == Approx(1 / (kFieldDepth * 0.25f)).epsilon(0.01));
  for (const float v : key.inverse_depth.samples()) REQUIRE(v == plane);
  CHECK_FALSE(key.knows_depth);
}

TEST_CASE("the motion between two keyframes leads both ways, and is doubted where it leaves the picture") {
  WorkerPool pool(2);
  KeyframeMaker maker(pool);
  Keyframe before = texture_at(0), after = texture_at(kStep_px);
  maker.complete(SnapshotHold(), nullptr, before);
  maker.complete(SnapshotHold(), &before, after);
  CHECK(mean_along(after.to_previous.vectors) == Approx(-kStep_px).margin(0.3));
  CHECK(mean_along(after.from_previous.vectors) == Approx(kStep_px).margin(0.3));
  CHECK(after.to_previous.confidence.at(0, kRows / 2, kCols / 2) > 0.8f);
  for (int y = 16; y < kRows - 16; ++y) {
    const float to = after.to_previous.vectors.at(0, y, 0),
                from = after.from_previous.vectors.at(0, y, kCols - 1);
    if (to < -0.5f) CHECK(after.to_previous.confidence.at(0, y, 0) == 0);
    if (from >= 0.5f) CHECK(after.from_previous.confidence.at(0, y, kCols - 1) == 0);
  }
}
