#include "render/rolling_shutter.h"

#include <cmath>

#include "tests/support/state_estimate.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 48, kCols = 64;
constexpr double kInterval_s = 0.04, kReadout_s = 0.02;

// Something soft and bright, round, that moves at one velocity through what is darker.
struct Ball {
  float x = 32, y = 24;    // at the frame's time stamp
  float vx = 10, vy = -4;  // pixels a frame interval

  float radiance(float at_x, float at_y, float intervals) const {
    const float dx = at_x - x - vx * intervals, dy = at_y - y - vy * intervals;
    return 0.05f + 2 * std::exp(-(dx * dx + dy * dy) / 72);
  }
};

float late(float y) { return static_cast<float>(kReadout_s / kInterval_s) * (y / kRows - 0.5f); }

// What all rows see, read one after the other or at once, in all three channels.
Image<float> picture_of(const Ball& ball, bool rolling) {
  Image<float> picture(3, kRows, kCols);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x)
        picture.at(c, y, x) = ball.radiance(static_cast<float>(x), static_cast<float>(y),
                                            rolling ? late(static_cast<float>(y)) : 0);
  return picture;
}

// Where the rows of a frame see the ball again in a frame `intervals` away.
FlowField motion_of(const Ball& ball, float intervals) {
  FlowField motion{Image<float>(2, kRows, kCols), Image<float>(1, kRows, kCols)};
  const float row_time = static_cast<float>(kReadout_s / kInterval_s) / kRows;
  const float elapsed = intervals / (1 - ball.vy * row_time);  // the row that sees it moves with it
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x)
      motion.vectors.at(0, y, x) = ball.vx * elapsed, motion.vectors.at(1, y, x) = ball.vy * elapsed;
  motion.confidence.fill(1);
  return motion;
}

enum class Toward { Previous, Next, Nowhere };

// Corrects a frame of the ball as its rows saw it.
void correct(HdrFrame& frame, const Ball& ball, Toward toward, double readout_s = kReadout_s,
             int threads = 2) {
  WorkerPool pool(threads);
  const FlowField back = motion_of(ball, -1), on = motion_of(ball, 1);
  ExposedFrame input;
  input.interval_s = kInterval_s;
  const RadianceEstimate state;
  const Image<float> own_share;
  FrameEstimate estimate = test::estimate_by_state(input, state, own_share);
  if (toward == Toward::Previous) estimate.to_previous = &back;
  if (toward == Toward::Next) estimate.to_next = &on.vectors;
  RollingShutterCorrection(pool).correct(estimate, readout_s, frame);
}

HdrFrame frame_of(const Ball& ball) {
  HdrFrame frame;
  frame.radiance = picture_of(ball, true);
  frame.sigma = Image<float>(1, kRows, kCols);
  frame.provenance = Image<std::uint8_t>(1, kRows, kCols);
  for (Image<float>* back : {&frame.flow, &frame.field_flow}) *back = motion_of(ball, -1).vectors;
  for (Image<float>* on : {&frame.flow_forward, &frame.field_flow_forward}) *on = motion_of(ball, 1).vectors;
  return frame;
}

HdrFrame corrected(const Ball& ball, Toward toward, double readout_s = kReadout_s, int threads = 2) {
  HdrFrame frame = frame_of(ball);
  correct(frame, ball, toward, readout_s, threads);
  return frame;
}

// Away from the border, from which nothing comes in.
float largest_difference(const Image<float>& a, const Image<float>& b) {
  float most = 0;
  for (int y = 8; y < kRows - 8; ++y)
    for (int x = 8; x < kCols - 8; ++x) most = std::max(most, std::abs(a.at(1, y, x) - b.at(1, y, x)));
  return most;
}

}  // namespace

TEST_CASE("what a rolling shutter skews stands upright again, from the motion to either neighbour") {
  const Ball ball{.vx = GENERATE(10.f, -14.f, 0.f), .vy = GENERATE(0.f, -4.f, 9.f)};
  const Image<float> upright = picture_of(ball, false);
  if (ball.vx != 0) REQUIRE(largest_difference(picture_of(ball, true), upright) > 0.07f);
  for (const Toward toward : {Toward::Previous, Toward::Next})
    CHECK(largest_difference(corrected(ball, toward).radiance, upright) < 0.02f);
}

TEST_CASE("the flow of a corrected frame is the motion in one frame interval") {
  const Ball ball{.vx = 6, .vy = 12};
  const HdrFrame frame = corrected(ball, Toward::Previous);
  for (const Image<float>* back : {&frame.flow, &frame.field_flow}) {
    CHECK(back->at(0, 24, 32) == Approx(-6).margin(1e-3));
    CHECK(back->at(1, 24, 32) == Approx(-12).margin(1e-3));
  }
  for (const Image<float>* on : {&frame.flow_forward, &frame.field_flow_forward}) {
    CHECK(on->at(0, 24, 32) == Approx(6).margin(1e-3));
    CHECK(on->at(1, 24, 32) == Approx(12).margin(1e-3));
  }
}

TEST_CASE("provenance and points of a frame go with its pixels under rolling shutter correction") {
  const Ball ball{.vx = 16, .vy = 0};
  HdrFrame frame = frame_of(ball);
  const int seen_x = 32 + static_cast<int>(std::lround(16 * late(8)));  // the ball's column in row 8
  frame.provenance.at(0, 8, seen_x) = 3;
  frame.points.push_back({.p_world = Eigen::Vector3d::Zero(), .u_px = seen_x + 0.5, .v_px = 8.5});
  frame.points.push_back({.p_world = Eigen::Vector3d::Zero(),
                          .u_px = 0.5,
                          .v_px = 47.5});  // was further left at the frame's moment
  for (int x = seen_x - 1; x <= seen_x + 1; ++x) frame.sigma.at(0, 8, x) = 1;
  correct(frame, ball, Toward::Previous);
  CHECK(frame.provenance.at(0, 8, 32) == 3);
  CHECK(frame.sigma.at(0, 8, 32) > 0.9f);
  REQUIRE(frame.points.size() == 1);
  CHECK(frame.points[0].u_px == Approx(32.5).margin(0.6));
  CHECK(frame.points[0].v_px == Approx(8.5));
}

TEST_CASE("a frame stays as it was read without a read-out time, and where no motion is known") {
  const Ball ball;
  const Image<float> read = picture_of(ball, true);
  const auto is_read = [&](const HdrFrame& frame) {
    return std::ranges::equal(frame.radiance.samples(), read.samples());
  };
  CHECK(is_read(corrected(ball, Toward::Previous, 0)));
  CHECK(is_read(corrected(ball, Toward::Nowhere)));
  CHECK(is_read(corrected(ball, Toward::Previous, kInterval_s * 2.01)));  // it cannot be
  CHECK_FALSE(
      is_read(corrected(ball, Toward::Previous, kInterval_s * 1.2)));  // before a short exposure it can
}

TEST_CASE("rolling shutter correction gives the same bytes on any number of threads") {
  const Ball ball;
  CHECK(std::ranges::equal(corrected(ball, Toward::Previous, kReadout_s, 1).radiance.samples(),
                           corrected(ball, Toward::Previous, kReadout_s, 3).radiance.samples()));
}

TEST_CASE("motion that is no motion moves nothing out of the picture under rolling shutter correction") {
  const Ball wild{.vx = 1e6f, .vy = GENERATE(-1e6f, 1e6f, 96.f, -96.f)};  // 96: as fast as the rows are read
  const HdrFrame frame = corrected(wild, Toward::Previous);
  for (const float v : frame.radiance.samples()) REQUIRE(std::isfinite(v));
}
