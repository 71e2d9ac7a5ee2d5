// The renderer against brute force: blur is the mean of instants, a rolling shutter is a different instant in
// each row.
#include <cmath>
#include <numbers>

#include "hal/sim/renderer.h"
#include "hal/sim/simulation.h"

#include "tests/allocation_checks.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 60, kCols = 80;

struct Stage {
  explicit Stage(const char* spec, int times = 1)
      : rows(times * kRows),
        cols(times * kCols),
        scene(make_scene(simulation_of(spec).value().scene, 64, pool)),
        lens{centred_intrinsics(cols, rows, std::numbers::pi / 3), std::nullopt} {}
  Renderer renderer(ShutterEffects shutter) { return Renderer(scene, lens, shutter, rows, cols, pool); }

  int rows, cols;
  WorkerPool pool{2};
  Scene scene;
  Lens lens;
};

ShutterEffects blurring() { return {MotionBlur({}), std::nullopt}; }

// Of a scene while the shutter is open: as rendered, the instant in the middle, and the mean of all instants.
struct Exposed {
  Exposed(Stage& stage, double begin_s, double open_s) : mean(3, stage.rows, stage.cols) {
    Renderer blurred = stage.renderer(blurring()), sharp = stage.renderer({});
    blurred.render({begin_s, begin_s + open_s}, picture);
    constexpr int kInstants = 64;
    for (int i = 0; i < kInstants; ++i) {
      const double time_s = begin_s + open_s * (i + 0.5) / kInstants;
      sharp.render({time_s, time_s}, middle);
      for (std::size_t k = 0; k < mean.size(); ++k) mean.samples()[k] += middle.samples()[k] / kInstants;
    }
    sharp.render({begin_s + open_s / 2, begin_s + open_s / 2}, middle);
  }
  // What the picture has of the blur that it should have: the slope of its logarithm, that of the instant in
  // the middle being 0, over that of the mean of all instants.
  double blur_shown() const {
    double by = 0, of = 0;
    for (std::size_t k = 0; k < mean.size(); ++k) {
      const double blur = static_cast<double>(std::log2(mean.samples()[k] / middle.samples()[k]));
      by += blur * static_cast<double>(std::log2(picture.samples()[k] / middle.samples()[k]));
      of += blur * blur;
    }
    return by / of;
  }

  Image<float> picture, middle, mean;
};

// Mean over the picture of |a - b| / (a + b), of the green channel.
double difference(const Image<float>& a, const Image<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.plane_size(); ++i)
    sum += static_cast<double>(std::abs(a.plane(1)[i] - b.plane(1)[i]) / (a.plane(1)[i] + b.plane(1)[i]));
  return sum / static_cast<double>(a.plane_size());
}

}  // namespace

TEST_CASE("motion blur is the mean of the instants of the exposure") {
  Stage stage("fast");
  const Exposed fast(stage, 1.0, 0.08);
  CHECK(difference(fast.picture, fast.mean) < 0.03);
  CHECK(difference(fast.picture, fast.mean) < 0.35 * difference(fast.middle, fast.mean));
}

TEST_CASE("what moves by some pixels blurs as far as it moves") {
  constexpr int kTimes = 2;
  double shown = 0;
  for (const char* spec : {"walk?seed=1", "walk?seed=2", "lamps?seed=1", "lamps?seed=3"}) {
    Stage stage(spec, kTimes);
    shown += Exposed(stage, 0.7, 0.06).blur_shown() / 4;
  }
  CHECK(shown == Approx(1).margin(0.1));
}

TEST_CASE("a sharp picture is the mean over the areas of its pixels, as a blurred one is") {
  constexpr int kTimes = 4;
  Stage stage("walk"), fine("walk", kTimes);
  Image<float> picture, dense, mean(3, kRows, kCols);
  stage.renderer({}).render({0.7, 0.7}, picture);
  fine.renderer({}).render({0.7, 0.7}, dense);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < fine.rows; ++y)
      for (int x = 0; x < fine.cols; ++x)
        mean.at(c, y / kTimes, x / kTimes) += dense.at(c, y, x) / (kTimes * kTimes);
  CHECK(difference(picture, mean) < 0.02);
}

TEST_CASE("a long exposure of a scene at rest is the sharp picture") {
  Stage stage("still");
  Renderer blurred = stage.renderer(blurring()), sharp = stage.renderer({});
  Image<float> open, closed;
  blurred.render({1.0, 1.03}, open);
  sharp.render({1.0, 1.0}, closed);
  CHECK(std::equal(open.samples().begin(), open.samples().end(), closed.samples().begin()));
}

TEST_CASE("a row under a rolling shutter is that row of the picture taken when it was read") {
  Stage stage("pan");
  const RollingShutter shutter({.readout = std::chrono::milliseconds(30)}, kRows);
  Renderer rolling = stage.renderer({std::nullopt, shutter}), global = stage.renderer({});
  Image<float> skewed, straight;
  rolling.render({0.2, 0.2}, skewed);
  double own_row = 0, first_row = 0;
  for (const int y : {10, 30, 50}) {
    const auto distance = [&](double time_s) {
      global.render({time_s, time_s}, straight);
      double sum = 0;
      for (int x = 0; x < kCols; ++x)
        sum += static_cast<double>(std::abs(std::log2(skewed.at(1, y, x) / straight.at(1, y, x))));
      return sum / kCols;
    };
    own_row += distance(0.2 + shutter.delay_s(y));
    first_row += distance(0.2);
  }
  CHECK(own_row < 0.15 * first_row);
}

TEST_CASE("a picture does not depend on the number of threads") {
  Stage one("walk"), two("walk");
  WorkerPool single(1);
  Renderer alone(one.scene, one.lens, blurring(), kRows, kCols, single), together = two.renderer(blurring());
  Image<float> a, b;
  alone.render({0.7, 0.716}, a);
  together.render({0.7, 0.716}, b);
  CHECK(std::equal(a.samples().begin(), a.samples().end(), b.samples().begin()));
}

TEST_CASE("rendering allocates nothing after the first frame") {
  Stage stage("night");
  Renderer renderer = stage.renderer(blurring());
  Image<float> picture;
  renderer.render({0.1, 0.116}, picture);
  const std::uint64_t before = allocations_so_far();
  for (int i = 0; i < 5; ++i) renderer.render({0.1 * i, 0.1 * i + 0.016}, picture);
  CHECK_ALLOCATIONS(allocations_so_far() == before);
}
