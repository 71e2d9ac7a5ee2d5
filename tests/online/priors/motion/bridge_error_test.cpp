#include "online/priors/motion/bridge_error.h"

#include <cmath>

#include "online/priors/motion/flow_effort.h"
#include "online/priors/motion/flow_kernels.h"
#include "tests/support/numbers.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 61, kCols = 93;  // no whole cells
constexpr int kLeft = 40, kTop = 24, kSide = 16;

// A picture that moves by 6 pixels to the frame after; the frame in between clips a square of it.
struct Shaken {
  int rows = kRows, cols = kCols, left = kLeft, top = kTop, side = kSide;
  Image<float> state_to_after{2, rows, cols}, after_to_state{2, rows, cols}, motion{2, rows, cols},
      clipped{1, rows, cols}, clipped_after{1, rows, cols};
  WorkerPool pool{1};

  Shaken() { move(); }
  Shaken(int rows_px, int cols_px, int left_px, int top_px, int side_px)
      : rows(rows_px), cols(cols_px), left(left_px), top(top_px), side(side_px) {
    move();
  }
  void move() {
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) show(x, y, 6, 0, 0);
    for (int y = top; y < top + side; ++y) std::fill_n(clipped.row(0, y) + left, side, 1.f);
  }
  // A pixel that moves by `whole`, and in between is off its middle by this.
  void show(int x, int y, float whole, float off_u, float off_v) {
    state_to_after.at(0, y, x) = whole, after_to_state.at(0, y, x) = -whole;
    motion.at(0, y, x) = -0.5f * whole + off_u, motion.at(1, y, x) = off_v;
  }
  bool is_clipped(int x, int y) const { return clipped.at(0, y, x) > 0; }
  // At the middle of the square.
  Image<float> compared() {
    const PathAhead path{after_to_state.plane(0), state_to_after.plane(0), nullptr, nullptr, 0.5f, 1,
                         motion_scale(rows, cols)};
    BridgeError error(rows, cols);
    error.compare(path, clipped, clipped_after, motion, pool);
    Image<float> at(2, 1, 1);
    for (int c = 0; c < 2; ++c)
      at.at(c, 0, 0) = error.cells().at(c, (top + side / 2) / kLandingCell, (left + side / 2) / kLandingCell);
    return at;
  }
};

}  // namespace

TEST_CASE("where a frame is clipped the path is off by as much as around it") {
  Shaken shaken;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) shaken.show(x, y, 6, 0.8f, -0.5f);
  const Image<float> off = shaken.compared();
  CHECK(off.at(0, 0, 0) == Approx(0.8).margin(0.08));
  CHECK(off.at(1, 0, 0) == Approx(-0.5).margin(0.05));
}

TEST_CASE("in a larger picture as large a part of it shows how far a path is off, and it is off by more") {
  struct Row {
    int rows, cols, side;  // of a square whose middle no cell of a small picture would reach
  };
  for (const auto& [rows, cols, side] : {Row{480, 640, 64}, {1080, 1920, 160}}) {
    Shaken shaken(rows, cols, (cols - side) / 2, (rows - side) / 2, side);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) shaken.show(x, y, 6, 1.6f, -1);
    const Image<float> off = shaken.compared();
    CAPTURE(cols);
    CHECK(off.at(0, 0, 0) == Approx(1.6).margin(0.4));
    CHECK(off.at(1, 0, 0) == Approx(-1).margin(0.25));
  }
}

TEST_CASE("what the path is off by is the same for any number of threads") {
  Shaken shaken;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) shaken.show(x, y, 6, 0.02f * static_cast<float>(x), -0.5f);
  const PathAhead path{
      shaken.after_to_state.plane(0), shaken.state_to_after.plane(0), nullptr, nullptr, 0.5f, 1};
  std::vector<float> results[2];
  for (const int threads : {1, 3}) {
    WorkerPool pool(threads);
    BridgeError error(kRows, kCols);
    error.compare(path, shaken.clipped, shaken.clipped_after, shaken.motion, pool);
    const auto samples = error.cells().samples();
    results[threads / 2].assign(samples.begin(), samples.end());
  }
  CHECK(results[0] == results[1]);
  CHECK(std::abs(results[0].front()) > 0.05f);
}

TEST_CASE("what differs from the path in all directions does not move what a frame clips") {
  Shaken shaken;
  test::Numbers numbers(3);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      const test::Row off = numbers.between(-0.5f, 0.7f, 2);  // .1 px to the lower right, in the mean
      shaken.show(x, y, 6, off[0], off[1]);
    }
  const Image<float> off = shaken.compared();
  CHECK(std::hypot(off.at(0, 0, 0), off.at(1, 0, 0)) < 0.02f);
}

TEST_CASE("what moves otherwise does not say how far the path of what a frame clips is off") {
  Shaken shaken;
  // the square and what is 12 pixels around it rest; everything else moves, and is off
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      const bool rests = std::abs(x - kLeft - kSide / 2) < 20 && std::abs(y - kTop - kSide / 2) < 20;
      shaken.show(x, y, rests ? 0 : 6, rests ? 0 : 0.8f, 0);
    }
  CHECK(std::abs(shaken.compared().at(0, 0, 0)) < 0.05f);
}

TEST_CASE("where nothing shows its motion the path stands") {
  Shaken shaken;
  shaken.clipped.fill(1);
  const Image<float> off = shaken.compared();
  CHECK(off.at(0, 0, 0) == 0);
  CHECK(off.at(1, 0, 0) == 0);
}
