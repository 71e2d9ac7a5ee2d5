#include "online/priors/motion/bridge_error.h"

#include <cmath>

#include "online/priors/motion/flow_kernels.h"
#include "tests/support/numbers.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 61, kCols = 93;  // no whole cells
constexpr int kLeft = 40, kTop = 24, kSide = 16;

// A picture that moves by 6 pixels to the frame after; the frame in between clips a square of it.
struct Shaken {
  Image<float> state_to_after{2, kRows, kCols}, after_to_state{2, kRows, kCols}, motion{2, kRows, kCols},
      clipped{1, kRows, kCols}, clipped_after{1, kRows, kCols};
  WorkerPool pool{1};

  Shaken() {
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) show(x, y, 6, 0, 0);
    for (int y = kTop; y < kTop + kSide; ++y) std::fill_n(clipped.row(0, y) + kLeft, kSide, 1.f);
  }
  // A pixel that moves by `whole`, and in between is off its middle by this.
  void show(int x, int y, float whole, float off_u, float off_v) {
    state_to_after.at(0, y, x) = whole, after_to_state.at(0, y, x) = -whole;
    motion.at(0, y, x) = -0.5f * whole + off_u, motion.at(1, y, x) = off_v;
  }
  bool is_clipped(int x, int y) const { return clipped.at(0, y, x) > 0; }
  // At the middle of the square.
  Image<float> compared() {
    const PathAhead path{after_to_state.plane(0), state_to_after.plane(0), nullptr, nullptr, 0.5f, 1};
    BridgeError error(kRows, kCols);
    error.compare(path, clipped, clipped_after, motion, pool);
    Image<float> at(2, 1, 1);
    for (int c = 0; c < 2; ++c)
      at.at(c, 0, 0) =
          error.cells().at(c, (kTop + kSide / 2) / kLandingCell, (kLeft + kSide / 2) / kLandingCell);
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
