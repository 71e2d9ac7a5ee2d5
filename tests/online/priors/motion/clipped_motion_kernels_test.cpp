#include "online/priors/motion/clipped_motion_kernels.h"

#include <cmath>

#include "hal/core/interpolate.h"
#include "online/pictures/between_pixels.h"
#include "tests/support/numbers.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 11;
constexpr float kShare = 0.4f, kRatio = 1.3f;

// Waves that are long enough for places rounded to 1/32 to make no difference above kRounding.
constexpr float kRounding = 0.03f;
Image<float> waves(int channels, int cols, float mean, float amplitude, float phase) {
  Image<float> out(channels, kRows, cols);
  for (int c = 0; c < channels; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < cols; ++x)
        out.at(c, y, x) =
            mean + amplitude * std::sin(0.11f * static_cast<float>(x) - 0.17f * static_cast<float>(y) +
                                        phase * static_cast<float>(c + 1));
  return out;
}

// Where nothing is clipped, eight pixels and more in a row, and where more or less is.
Image<float> clipped_here(int cols) {
  Image<float> out(1, kRows, cols);
  test::Numbers numbers(5);
  for (int y = 0; y < kRows; ++y) {
    const test::Row shares = numbers.between(0, 1, cols);
    for (int x = 0; x < cols; ++x) out.at(0, y, x) = y % 3 == 0 || x / 20 % 2 == 1 ? 0 : shares[x];
  }
  return out;
}

struct Pictures {
  Image<float> clipped, clipped_after, motion, measured, after_to_state, state_to_after;
  explicit Pictures(int cols)
      : clipped(clipped_here(cols)),
        clipped_after(waves(1, cols, 0.4f, 0.3f, 1)),
        motion(waves(2, cols, 0.5f, 3, 2)),
        measured(waves(1, cols, 0.5f, 0.4f, 3)),
        after_to_state(waves(2, cols, 2, 3, 4)),
        state_to_after(waves(2, cols, -2, 2.5f, 5)) {}
};

// A motion as it is and as it should be: at every pixel, and as it was where the frame clips nothing.
void check(const Image<float>& is, const Image<float>& should_be) {
  for (int c = 0; c < is.channels(); ++c)
    for (int y = 0; y < is.rows(); ++y)
      for (int x = 0; x < is.cols(); ++x) {
        INFO(is.cols() << " columns, pixel " << x << ", " << y << ", channel " << c);
        REQUIRE(is.at(c, y, x) == Approx(should_be.at(c, y, x)).margin(kRounding));
      }
}
void take_over(Image<float>& motion, int x, int y, float share, Offset from) {
  motion.at(0, y, x) += share * (from.x - motion.at(0, y, x));
  motion.at(1, y, x) += share * (from.y - motion.at(1, y, x));
}

template <class Body>
void at_clipped(const Image<float>& clipped, float begin, float end, Body&& body) {
  for (int y = 0; y < clipped.rows(); ++y)
    for (int x = 0; x < clipped.cols(); ++x) {
      const float share = smooth_step(begin, end, clipped.at(0, y, x));
      if (share > 0) body(x, y, share);
    }
}

}  // namespace

TEST_CASE("the last motion goes on where a frame is clipped, and less where nobody measured it", "[isa]") {
  for (const int cols : {3, 8, 64, 83}) {
    const Pictures pictures(cols);
    Image<float> motion = pictures.motion.clone(), now(1, kRows, cols);
    const Image<float> last = waves(2, cols, -1, 3, 6);
    for (int y = 0; y < kRows; ++y)
      clipped_motion_kernels().go_on({{kRows, cols, y},
                                      pictures.clipped.row(0, y),
                                      last.plane(0),
                                      pictures.measured.plane(0),
                                      kRatio,
                                      motion.row(0, y),
                                      motion.row(1, y),
                                      now.row(0, y)});
    Image<float> expected = pictures.motion.clone(), expected_now(1, kRows, cols);
    expected_now.fill(1);
    at_clipped(pictures.clipped, 0.5f, 0.95f, [&](int x, int y, float clipped) {
      const BetweenPixels there(kRows, cols, x, y, offset_at(pictures.motion, x, y));
      const float measured = there.of(pictures.measured, 0), share = clipped * smooth_step(0, 1, measured);
      take_over(expected, x, y, share, kRatio * there.vector_of(last));
      expected_now.at(0, y, x) = 1 - share * (1 - 0.9f * measured);
    });
    check(motion, expected);
    check(now, expected_now);
  }
}

TEST_CASE("what a frame clips moves as the state and the frame after it say, at their places", "[isa]") {
  for (const int cols : {3, 8, 64, 83}) {
    const Pictures pictures(cols);
    Image<float> motion = pictures.motion.clone(), measured = pictures.measured.clone();
    for (int y = 0; y < kRows; ++y)
      clipped_motion_kernels().bridge({{kRows, cols, y},
                                       pictures.clipped.row(0, y),
                                       pictures.clipped_after.plane(0),
                                       pictures.after_to_state.plane(0),
                                       pictures.state_to_after.plane(0),
                                       kShare,
                                       motion.row(0, y),
                                       motion.row(1, y),
                                       measured.row(0, y)});
    constexpr float kToAfter = -(1 - kShare) / kShare;
    Image<float> expected = pictures.motion.clone(), expected_measured = pictures.measured.clone();
    at_clipped(pictures.clipped, 0.4f, 0.9f, [&](int x, int y, float clipped) {
      Offset back;
      const auto in_after = [&] { return BetweenPixels(kRows, cols, x, y, kToAfter * back); };
      for (int round = 0; round < 3; ++round) {
        const Offset after = in_after().vector_of(pictures.after_to_state);
        const Offset before = BetweenPixels(kRows, cols, x, y, back).vector_of(pictures.state_to_after);
        back = 0.5f * kShare * Offset{after.x - before.x, after.y - before.y};
      }
      const float share = clipped * (1 - smooth_step(0.1f, 0.6f, in_after().of(pictures.clipped_after, 0)));
      take_over(expected, x, y, share, back);
      expected_measured.at(0, y, x) += share * (1 - pictures.measured.at(0, y, x));
    });
    check(motion, expected);
    check(measured, expected_measured);
  }
}

TEST_CASE("the state's pixels move over a frame that clips them as they do to the frame after it", "[isa]") {
  for (const int cols : {3, 8, 64, 83}) {
    const Pictures pictures(cols);
    Image<float> motion = pictures.motion.clone();
    for (int y = 0; y < kRows; ++y)
      clipped_motion_kernels().bridge_ahead({{kRows, cols, y},
                                             pictures.clipped.row(0, y),
                                             pictures.clipped_after.plane(0),
                                             pictures.state_to_after.plane(0),
                                             kShare,
                                             motion.row(0, y),
                                             motion.row(1, y)});
    Image<float> expected = pictures.motion.clone();
    at_clipped(pictures.clipped, 0.4f, 0.9f, [&](int x, int y, float clipped) {
      const Offset whole = offset_at(pictures.state_to_after, x, y);
      const float after = BetweenPixels(kRows, cols, x, y, whole).of(pictures.clipped_after, 0);
      take_over(expected, x, y, clipped * (1 - smooth_step(0.1f, 0.6f, after)), kShare * whole);
    });
    check(motion, expected);
  }
}
