#include "render/views/view_renderer.h"

#include <algorithm>
#include <cmath>

#include "render/srgb.h"
#include "render/views/re_exposure.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 40, kCols = 60;
constexpr float kFieldRadiance = 77;
const Intrinsics kLens{50, 50, kCols / 2.0, kRows / 2.0};

// A field that answers with one colour where it is asked.
class OneColour final : public FieldSnapshot {
 public:
  void look(const SceneView& view, WorkerPool&, FieldPicture& picture) const override {
    picture.radiance.reshape(3, view.rows, view.cols);
    picture.depth.reshape(1, view.rows, view.cols);
    picture.radiance.fill(0), picture.depth.fill(9);
    for (std::size_t i = 0; i < view.wanted->size(); ++i)
      for (int c = 0; c < 3; ++c)
        if (view.wanted->samples()[i] != 0) picture.radiance.plane(c)[i] = kFieldRadiance;
  }
};

// A wall of smooth waves at a depth of 4, and a square in front of it at 2 that is `moved` pixels to the
// right.
float wall(float x, float y, int channel) {
  return 2 + std::sin(0.4f * x + static_cast<float>(channel)) + std::cos(0.3f * y);
}
bool on_square(float x, float y, float moved) { return std::abs(x - 30 - moved) < 8 && std::abs(y - 20) < 8; }
float square(float x, float y, float moved) { return 20 + std::sin(0.5f * (x - moved)) + std::cos(0.5f * y); }

Keyframe seen(double time_s, float moved, bool has_square) {
  Keyframe key;
  key.time_s = time_s, key.lens = kLens;
  key.frame.white = 30;
  key.frame.radiance.reshape(3, kRows, kCols);
  for (Image<float>* plane : {&key.frame.sigma, &key.inverse_depth}) plane->reshape(1, kRows, kCols);
  key.frame.sigma.fill(0.1f);
  key.frame.provenance.reshape(1, kRows, kCols);
  key.frame.provenance.fill(static_cast<std::uint8_t>(Provenance::Own));
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
      const bool near = has_square && on_square(px, py, moved);
      key.inverse_depth.at(0, y, x) = near ? 0.5f : 0.25f;
      for (int c = 0; c < 3; ++c)
        key.frame.radiance.at(c, y, x) = near ? square(px, py, moved) : wall(px, py, c);
    }
  return key;
}

// Motion of the square by `step` pixels, the wall at rest.
FlowField motion_of(const Keyframe& key, float step) {
  FlowField flow;
  flow.vectors.reshape(2, kRows, kCols), flow.vectors.fill(0);
  flow.confidence.reshape(1, kRows, kCols), flow.confidence.fill(1);
  for (std::size_t i = 0; i < key.inverse_depth.size(); ++i)
    if (key.inverse_depth.samples()[i] > 0.3f) flow.vectors.plane(0)[i] = step;
  return flow;
}

SceneView view_from(const Eigen::Vector3d& shift) {
  SceneView view;
  view.T_world_camera.t = shift;
  view.lens = kLens, view.rows = kRows, view.cols = kCols;
  return view;
}

HdrFrame rendered(const KeyframeInterval& interval, const SceneView& view,
                  const FieldSnapshot& field = OneColour()) {
  WorkerPool pool(2);
  ViewRenderer renderer(pool);
  HdrFrame frame;
  renderer.render(interval, view, SnapshotHold(field), frame);
  return frame;
}

}  // namespace

TEST_CASE("a frame's own view at its own time is its own picture, to the bit", "[views]") {
  const Keyframe key = seen(0, 0, true);
  const HdrFrame frame = rendered({&key, nullptr, 0}, view_from({0, 0, 0}));
  CHECK(std::ranges::equal(frame.radiance.samples(), key.frame.radiance.samples()));
  CHECK(std::ranges::equal(frame.provenance.samples(), key.frame.provenance.samples()));
}

TEST_CASE("from further right a wall is seen moved to the left, by focal length times shift over depth",
          "[views]") {
  const Keyframe key = seen(0, 0, false);
  const HdrFrame frame = rendered({&key, nullptr, 0}, view_from({0.4, 0, 0}));  // 50 * 0.4 / 4 = 5 px
  for (int y = 2; y < kRows - 2; ++y)
    for (int x = 2; x < kCols - 8; ++x)
      CHECK(frame.radiance.at(1, y, x) ==
            Approx(wall(static_cast<float>(x) + 5.5f, static_cast<float>(y) + 0.5f, 1)).margin(0.01));
  CHECK(frame.depth.at(0, 20, 20) == Approx(4));
}

TEST_CASE("a near square covers the wall, and what it uncovers is the field's and says so", "[views]") {
  const Keyframe key = seen(0, 0, true);
  const HdrFrame frame =
      rendered({&key, nullptr, 0}, view_from({0.4, 0, 0}));  // the square moves by 10, the wall by 5
  for (int y = 14; y < 26; ++y) {
    for (int x = 14; x < 26; ++x)
      CHECK(frame.radiance.at(0, y, x) ==
            Approx(square(static_cast<float>(x) + 10.5f, static_cast<float>(y) + 0.5f, 0)).margin(0.02));
    for (int x = 29; x < 32; ++x) {
      CHECK(frame.radiance.at(0, y, x) == kFieldRadiance);
      CHECK(frame.provenance.at(0, y, x) == static_cast<std::uint8_t>(Provenance::Field));
    }
    CHECK(frame.provenance.at(0, y, 40) == static_cast<std::uint8_t>(Provenance::Own));
  }
}

TEST_CASE(
    "between two frames what moves is on its way, and what it uncovers comes from the frame that saw it",
    "[views]") {
  Keyframe before = seen(0, 0, true), after = seen(1, 8, true);
  after.from_previous = motion_of(before, 8);
  after.to_previous = motion_of(after, -8);
  for (const double share : {0.25, 0.5, 0.75}) {
    const auto moved = static_cast<float>(8 * share);
    const HdrFrame frame = rendered({&before, &after, share}, view_from({0, 0, 0}));
    for (int y = 14; y < 26; ++y)
      for (int x = 0; x < kCols; ++x) {
        const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
        const float edge = std::abs(std::abs(px - 30 - moved) - 8);
        if (edge < 1.5f) continue;
        const float truth = on_square(px, py, moved) ? square(px, py, moved) : wall(px, py, 0);
        CHECK(frame.radiance.at(0, y, x) == Approx(truth).margin(0.05));
      }
  }
}

TEST_CASE("the depth of a view is that of the surface which it shows", "[views]") {
  Keyframe with = seen(0, 0, true), without = seen(1, 0, false);
  const bool first = GENERATE(true, false);
  const Keyframe &before = first ? with : without, &after = first ? without : with;
  for (const double share : {0.25, 0.5, 0.75}) {
    const HdrFrame frame = rendered({&before, &after, share}, view_from({0, 0, 0}));
    CHECK(frame.radiance.at(0, 20, 30) == Approx(square(30.5f, 20.5f, 0)).margin(0.02));
    CHECK(frame.depth.at(0, 20, 30) == Approx(2));  // the square's, not the wall's behind it
    CHECK(frame.depth.at(0, 20, 50) == Approx(4));
  }
}

TEST_CASE("a view states no depth while none of its scene is known", "[views]") {
  const Keyframe known = seen(1, 0, false);
  Keyframe unknown = seen(0, 0, false);
  unknown.knows_depth = false;
  const SceneView view = view_from({0.4, 0, 0});
  CHECK(rendered({&unknown, nullptr, 0}, view).depth.empty());
  CHECK(rendered({&unknown, &known, 0.5}, view).depth.empty());
  CHECK_FALSE(rendered({&unknown, &known, 1}, view).depth.empty());
  CHECK_FALSE(rendered({&known, nullptr, 0}, view).depth.empty());
}

TEST_CASE("a view of twice the size shows the same scene", "[views]") {
  const Keyframe key = seen(0, 0, false);
  SceneView large = view_from({0, 0, 0});
  large.rows *= 2, large.cols *= 2;
  large.lens = {100, 100, kCols, kRows};
  const HdrFrame frame = rendered({&key, nullptr, 0}, large);
  for (int y = 4; y < 2 * kRows - 4; ++y)
    for (int x = 4; x < 2 * kCols - 4; ++x)
      CHECK(frame.radiance.at(2, y, x) ==
            Approx(wall((static_cast<float>(x) + 0.5f) / 2, (static_cast<float>(y) + 0.5f) / 2, 2))
                .margin(0.02));
}

TEST_CASE(
    "a pixel of a reduced view is the mean of the pixels that it covers, so that no fine texture aliases",
    "[views]") {
  Keyframe key = seen(0, 0, false);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x)
      for (int c = 0; c < 3; ++c) key.frame.radiance.at(c, y, x) = (x + 2 * y) % 5 == c ? 20 : 1;
  const float side_px = GENERATE(4.f, 2.5f);
  SceneView small = view_from({0, 0, 0});
  small.rows = static_cast<int>(kRows / side_px), small.cols = static_cast<int>(kCols / side_px);
  small.lens = {50.0 / side_px, 50.0 / side_px, small.cols / 2.0, small.rows / 2.0};
  const HdrFrame frame = rendered({&key, nullptr, 0}, small);
  const auto covered = [&](int pixel, int by) {
    const auto from = static_cast<float>(by) * side_px, begin = static_cast<float>(pixel);
    return std::clamp(std::min(begin + 1, from + side_px) - std::max(begin, from), 0.f, 1.f);
  };
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x)
      for (int c = 0; c < 3; ++c) {
        float mean = 0;
        for (int v = 0; v < kRows; ++v)
          for (int u = 0; u < kCols; ++u)
            mean += covered(v, y) * covered(u, x) * key.frame.radiance.at(c, v, u) / (side_px * side_px);
        CAPTURE(side_px, y, x, c);
        CHECK(frame.radiance.at(c, y, x) == Approx(mean).epsilon(3e-3));
      }
}

TEST_CASE("from far away a wall is seen without aliasing, too", "[views]") {
  Keyframe key = seen(0, 0, false);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x)
      for (int c = 0; c < 3; ++c) key.frame.radiance.at(c, y, x) = (x + 2 * y) % 5 == c ? 20 : 1;
  const HdrFrame frame = rendered({&key, nullptr, 0}, view_from({0, 0, -12}));  // four times, at a depth of 4
  for (int y = 16; y < 24; ++y)
    for (int x = 24; x < 36; ++x)
      CHECK(frame.radiance.at(1, y, x) == Approx(4.8).margin(1.2));  // between pixels it is often 1
}

TEST_CASE("a camera half way between two turns half way", "[views]") {
  RigidTransform a, b;
  b.R = rotation(Eigen::Vector3d(0, 0.2, 0)), b.t = {1, 2, 3};
  const RigidTransform half = between(a, b, 0.5);
  CHECK((half.R - rotation(Eigen::Vector3d(0, 0.1, 0))).norm() < 1e-9);
  CHECK((half.t - Eigen::Vector3d(0.5, 1, 1.5)).norm() < 1e-12);
}

TEST_CASE("an exposure of its own goes through the camera's response and clips where the camera does",
          "[views]") {
  const Response response = Response::gamma(2.2f);
  Image<float> picture(3, 1, 3);
  for (int c = 0; c < 3; ++c) picture.at(c, 0, 0) = 0.25f, picture.at(c, 0, 1) = 1, picture.at(c, 0, 2) = 50;
  expose_again(0.5, response, picture);
  const Image<std::uint8_t> codes = codes_of_light(picture);
  CHECK(codes.at(0, 0, 0) == Approx(255 * std::pow(0.125, 1 / 2.2)).margin(1));
  CHECK(codes.at(1, 0, 1) == Approx(255 * std::pow(0.5, 1 / 2.2)).margin(1));
  CHECK(codes.at(2, 0, 2) == 255);
}

TEST_CASE("the light of 8-bit pictures gives back every code", "[views]") {
  Image<float> light(1, 1, 256);
  for (int code = 0; code < 256; ++code) light.at(0, 0, code) = srgb_light(static_cast<float>(code) / 255);
  const Image<std::uint8_t> codes = codes_of_light(light);
  for (int code = 0; code < 256; ++code) CHECK(codes.at(0, 0, code) == code);
}
