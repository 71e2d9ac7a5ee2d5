#include "online/state/shown_blur.h"

#include <algorithm>
#include <cmath>

#include "tests/online/state/known_scene.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::quiet_tables;

namespace {

constexpr int kRows = 120, kCols = 160;
constexpr float kShiftX = 6, kShiftY = 3;  // pixels
constexpr double kInterval_s = 1 / 30.0;

// What a frame shows of a texture without a direction, which the state knows.
struct Moving {
  RadianceState state = test::known_scene(
      kRows, kCols, [](int, int y, int x) { return light(static_cast<float>(x), static_cast<float>(y)); });
  FlowField motion = test::uniform_flow(kRows, kCols, kShiftX, kShiftY);
  ExposedFrame frame;
  WorkerPool pool;

  explicit Moving(double exposure_s, int threads = 1) : pool(threads) {
    frame.facts.exposure_s = exposure_s;
    frame.facts.exposure_source = ExposureSource::Reported;
    frame.interval_s = kInterval_s;
    frame.blur_fraction = exposure_s <= kInterval_s ? static_cast<float>(exposure_s / kInterval_s) : 0;
    frame.codes = Image<float>(3, kRows, kCols);
    show(1, 0, 0);
  }
  static float light(float x, float y) {
    const auto wave = [&](float across, float down) { return std::sin(across * x + down * y); };
    return 0.2f + 0.025f * (wave(0.9f, 0.1f) + wave(-0.1f, 0.9f) + wave(0.7f, 0.6f) + wave(-0.6f, 0.7f));
  }
  // The mean over `n` places on a line of this many pixels through each pixel's.
  void show(int n, float over_x, float over_y) {
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) {
          float sum = 0;
          for (int i = 0; i < n; ++i) {
            const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(n) - 0.5f;
            sum += light(static_cast<float>(x) + kShiftX + t * over_x,
                         static_cast<float>(y) + kShiftY + t * over_y);
          }
          frame.codes.at(c, y, x) = quiet_tables().code(c, sum / static_cast<float>(n));
        }
  }
  float stated() const { return ShownBlur::stated(frame); }
  void show_blur(float share) { show(15, share * kShiftX, share * kShiftY); }
  // Of a stream of such frames.
  bool shown(int frames = 12) {
    ShownBlur blur(pool);
    for (int i = 0; i < frames; ++i) {
      blur.observe_exposure(frame);
      blur.observe({frame, state, motion, quiet_tables(), unseen_variance_from(4)}, stated());
    }
    return blur.shown();
  }
};

}  // namespace

TEST_CASE("motion blur that exposure times state counts until frames contradict it") {
  Moving moving(0.02);
  CHECK(moving.stated() == Approx(0.6));
  CHECK_FALSE(moving.shown());
  CHECK(moving.shown(0));
  moving.show_blur(0.6f);
  CHECK(moving.shown());
  moving.show_blur(0);
  moving.motion.confidence.fill(0.5f);
  CHECK(moving.shown());  // perhaps it is the motion
  moving.motion.confidence.fill(1);
  std::fill_n(moving.motion.vectors.plane(0), 2 * moving.motion.vectors.plane_size(), 0.2f);
  CHECK(moving.shown());  // what hardly moves does not tell
}

TEST_CASE("where exposures outlast their frames motion blur counts only if frames show it") {
  Moving moving(0.05);
  CHECK(moving.stated() == Approx(1.5));
  CHECK_FALSE(moving.shown());
  ShownBlur blur(moving.pool);
  CHECK(blur.counted(0.6f) == 0.6f);
  blur.observe_exposure(moving.frame);
  CHECK(blur.counted(0.6f) == 0);  // of no frame, as long as it may be
  moving.show_blur(1.5f);
  CHECK(moving.shown());
  CHECK(Moving(10).shown() == false);
}

TEST_CASE(
    "an exposure that ends a frame after a short one does not outlast its frame, however near the centres "
    "are") {
  Moving moving(0.05);
  moving.frame.blur_fraction = 1.5f;  // as capture/ states it of such a frame
  CHECK(moving.stated() == 1.5f);
  ShownBlur blur(moving.pool);
  for (int i = 0; i < 6; ++i) blur.observe_exposure(moving.frame);
  CHECK(blur.counted(moving.stated()) == 1.5f);
}

TEST_CASE("what blurs in all directions is no motion blur") {
  Moving moving(0.05);
  moving.show_blur(1.5f);
  const Image<float> along = moving.frame.codes.clone();
  moving.show(15, -1.5f * kShiftY, 1.5f * kShiftX);
  for (std::size_t i = 0; i < along.size(); ++i)
    moving.frame.codes.samples()[i] = (moving.frame.codes.samples()[i] + along.samples()[i]) / 2;
  CHECK_FALSE(moving.shown());
}

TEST_CASE("edges along the motion tell nothing of motion blur") {
  Moving moving(0.02);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x)
      for (int c = 0; c < 3; ++c) {
        const float across = (static_cast<float>(y) * kShiftX - static_cast<float>(x) * kShiftY) / 7;
        moving.state.radiance.at(c, y, x) = 0.2f + 0.05f * std::sin(across);
        moving.frame.codes.at(c, y, x) = quiet_tables().code(c, moving.state.radiance.at(c, y, x));
      }
  CHECK(moving.shown());
}

TEST_CASE("a time stamp that jitters is no reason to doubt motion blur") {
  Moving early(0.036), usual(0.03);
  WorkerPool pool(1);
  ShownBlur blur(pool);
  for (int i = 0; i < 100; ++i) blur.observe_exposure(i % 20 == 3 ? early.frame : usual.frame);
  CHECK(blur.shown());
  Moving lost(0.1);  // a time stamp that is far too early
  blur.observe_exposure(lost.frame);
  CHECK(blur.shown());
  for (int i = 0; i < 100; ++i) blur.observe_exposure(i % 3 == 2 ? early.frame : usual.frame);
  CHECK_FALSE(blur.shown());
  ShownBlur begun(pool);
  begun.observe_exposure(lost.frame);
  CHECK_FALSE(begun.shown());
  for (int i = 0; i < 20; ++i) begun.observe_exposure(usual.frame);
  CHECK(begun.shown());
}

TEST_CASE("what frames show of motion blur does not depend on the number of threads") {
  Moving alone(0.05, 1), shared(0.05, 3);
  alone.show_blur(1.5f), shared.show_blur(1.5f);
  for (int frames = 1; frames < 6; ++frames) CHECK(alone.shown(frames) == shared.shown(frames));
}

TEST_CASE("an exposure without a time, or of a stream without intervals, states no motion blur") {
  Moving moving(0.02);
  moving.frame.blur_fraction = 0;
  CHECK(moving.stated() == 0);
  moving.frame.facts.exposure_s = 1;
  moving.frame.interval_s = 0;
  CHECK(moving.stated() == 0);
}
