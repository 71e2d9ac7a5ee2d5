#include "online/priors/motion/clipped_motion_kernels.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "hal/core/smooth_step.h"
#include "online/pictures/between_pixels.h"
#include "online/priors/motion/flow_kernels.h"
#include "tests/support/numbers.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 11;
// a share whose product with a motion is exact, so that the same pixel is the nearest
constexpr float kShare = 0.25f, kBefore = 0.3f, kRatio = 1.3f;

constexpr float kRounding = 1e-3f;
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
  Image<float> clipped, clipped_after, motion, measured, after_to_state, state_to_after, last,
      measured_before;
  explicit Pictures(int cols)
      : clipped(clipped_here(cols)),
        clipped_after(waves(1, cols, 0.4f, 0.3f, 1)),
        motion(waves(2, cols, 0.5f, 3, 2)),
        measured(waves(1, cols, 0.5f, 0.4f, 3)),
        after_to_state(waves(2, cols, 2, 3, 4)),
        state_to_after(waves(2, cols, -2, 2.5f, 5)),
        last(waves(2, cols, -1, 3, 6)),
        measured_before(waves(1, cols, 0.96f, 0.04f, 7)) {}

  PathAhead path(bool changes) const {
    return {after_to_state.plane(0),
            state_to_after.plane(0),
            changes ? last.plane(0) : nullptr,
            changes ? measured_before.plane(0) : nullptr,
            kShare,
            kBefore};
  }
};

Offset operator+(Offset a, Offset b) { return {a.x + b.x, a.y + b.y}; }
Offset limited(Offset by, float per_pixel2) {
  return 1 / (1 + per_pixel2 * (by.x * by.x + by.y * by.y)) * by;
}
// The part of a path at constant acceleration that one at constant velocity has not: s(t) = a t^2 + b t with
// s(1) = whole and s(-kBefore) = last.
Offset bend_of(Offset whole, Offset last, float measured) {
  const auto acceleration = [](float end, float start) { return (end + start / kBefore) / (1 + kBefore); };
  const float share = 0.6f * smooth_step(0.9f, 1, measured) * kShare * (1 - kShare);
  return limited(share * Offset{acceleration(whole.x, last.x), acceleration(whole.y, last.y)}, 0.25f);
}

// The pixel that is nearest to where one is when it is moved.
class NearestPixel {
 public:
  NearestPixel(int cols, int x, int y, Offset by) : x_(nearest(x, by.x, cols)), y_(nearest(y, by.y, kRows)) {}
  float of(const Image<float>& picture, int channel) const { return picture.at(channel, y_, x_); }
  Offset vector_of(const Image<float>& vectors) const { return offset_at(vectors, x_, y_); }

 private:
  static int nearest(int at, float by, int size) {
    return static_cast<int>(std::clamp(static_cast<float>(at) + by, 0.f, static_cast<float>(size - 1)) +
                            0.5f);
  }
  int x_, y_;
};

// Where a pixel of the clipped frame comes from and goes to, in two rounds from rest.
struct Crossing {
  const Pictures& pictures;
  int x, y;
  Offset back, whole;

  Crossing(const Pictures& given, int x_, int y_, bool changes) : pictures(given), x(x_), y(y_) {
    for (int round = 0; round < 2; ++round) {
      const NearestPixel there(pictures.clipped.cols(), x, y, back);
      const Offset after = in_after().vector_of(pictures.after_to_state),
                   before = there.vector_of(pictures.state_to_after);
      whole = 0.5f * Offset{before.x - after.x, before.y - after.y};
      back = -kShare * whole;
      if (changes)
        back = back + bend_of(whole, there.vector_of(pictures.last), there.of(pictures.measured_before, 0));
    }
  }
  NearestPixel in_after() const { return {pictures.clipped.cols(), x, y, back + whole}; }
  float seen_after() const { return 1 - smooth_step(0.1f, 0.6f, in_after().of(pictures.clipped_after, 0)); }
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

TEST_CASE("a motion goes on as predicted where a frame is clipped, and less where nobody measured it",
          "[isa]") {
  for (const int cols : {3, 8, 64, 83}) {
    const Pictures pictures(cols);
    Image<float> motion = pictures.motion.clone(), now(1, kRows, cols);
    for (int y = 0; y < kRows; ++y)
      clipped_motion_kernels().go_on({{kRows, cols, y},
                                      pictures.clipped.row(0, y),
                                      pictures.last.plane(0),
                                      pictures.measured.plane(0),
                                      kRatio,
                                      motion.row(0, y),
                                      motion.row(1, y),
                                      now.row(0, y)});
    Image<float> expected = pictures.motion.clone(), expected_now(1, kRows, cols);
    expected_now.fill(1);
    at_clipped(pictures.clipped, 0.5f, 0.95f, [&](int x, int y, float clipped) {
      const NearestPixel there(cols, x, y, offset_at(pictures.motion, x, y));
      const float measured = there.of(pictures.measured, 0), share = clipped * smooth_step(0, 1, measured);
      take_over(expected, x, y, share, kRatio * there.vector_of(pictures.last));
      expected_now.at(0, y, x) = 1 - share * (1 - 0.9f * measured);
    });
    check(motion, expected);
    check(now, expected_now);
  }
}

TEST_CASE("what a frame clips moves as the frames around it say, at their places", "[isa]") {
  for (const int cols : {3, 8, 64, 83})
    for (const bool changes : {false, true}) {
      const Pictures pictures(cols);
      Image<float> motion = pictures.motion.clone(), measured = pictures.measured.clone();
      Image<float> nowhere(1, 1, cols / kLandingCell + 1);
      nowhere.fill(kNowhere);
      for (int y = 0; y < kRows; ++y)
        clipped_motion_kernels().bridge({{kRows, cols, y},
                                         pictures.clipped.row(0, y),
                                         pictures.clipped_after.plane(0),
                                         pictures.path(changes),
                                         nowhere.row(0, 0),
                                         nowhere.row(0, 0),
                                         pictures.motion.plane(0),
                                         motion.row(0, y),
                                         motion.row(1, y),
                                         measured.row(0, y)});
      Image<float> expected = pictures.motion.clone(), expected_measured = pictures.measured.clone();
      at_clipped(pictures.clipped, 0.4f, 0.9f, [&](int x, int y, float clipped) {
        const Crossing path(pictures, x, y, changes);
        const float share = clipped * path.seen_after();
        take_over(expected, x, y, share, path.back);
        expected_measured.at(0, y, x) += share * (1 - pictures.measured.at(0, y, x));
      });
      check(motion, expected);
      check(measured, expected_measured);
    }
}

TEST_CASE("what a frame shows of its motion is compared with the path, cell by cell", "[isa]") {
  for (const int cols : {3, 8, 64, 83})
    for (const bool changes : {false, true}) {
      Pictures pictures(cols);
      for (float& share : pictures.clipped.samples()) share = share < 0.3f ? 0 : share;
      for (float& share : pictures.clipped_after.samples()) share = share < 0.4f ? 0 : share;
      for (int y = 0; y < kRows; ++y) {  // half of what the frame shows is near the path
        for (int x = 0; x < cols; x += 2) {
          const Offset back = Crossing(pictures, x, y, changes).back;
          pictures.motion.at(0, y, x) = back.x + 0.7f, pictures.motion.at(1, y, x) = back.y - 0.4f;
        }
      }
      for (const int y : {0, 4, 10}) {
        const int cells = (cols + kLandingCell - 1) / kLandingCell;
        std::vector<CheckedPathCell> is(static_cast<std::size_t>(cells)), should_be(is.size());
        clipped_motion_kernels().compare({{kRows, cols, y},
                                          pictures.clipped.row(0, y),
                                          pictures.clipped_after.plane(0),
                                          pictures.path(changes),
                                          pictures.motion.row(0, y),
                                          pictures.motion.row(1, y),
                                          is.data()});
        float told = 0;
        for (int x = 0; x < cols; ++x) {
          CheckedPathCell& cell = should_be[static_cast<std::size_t>(x / kLandingCell)];
          const Crossing path(pictures, x, y, changes);
          const Offset off = offset_at(pictures.motion, x, y) + -1 * path.back;
          const float off2 = off.x * off.x + off.y * off.y;
          ++cell.pixels, cell.path_u += path.back.x, cell.path_v += path.back.y;
          if (pictures.clipped.at(0, y, x) > 0.05f || path.seen_after() < 0.95f || off2 >= 1) continue;
          ++cell.told, cell.off_u += off.x, cell.off_v += off.y, cell.off2 += off2, ++told;
        }
        if (cols > 8) CHECK(told > 4);
        for (std::size_t i = 0; i < is.size(); ++i) {
          INFO(cols << " columns, row " << y << ", cell " << i);
          CHECK(is[i].pixels == should_be[i].pixels);
          CHECK(is[i].path_u == Approx(should_be[i].path_u).margin(1e-2));
          CHECK(is[i].path_v == Approx(should_be[i].path_v).margin(1e-2));
          CHECK(is[i].told == should_be[i].told);
          CHECK(is[i].off_u == Approx(should_be[i].off_u).margin(1e-2));
          CHECK(is[i].off_v == Approx(should_be[i].off_v).margin(1e-2));
          CHECK(is[i].off2 == Approx(should_be[i].off2).margin(1e-2));
        }
      }
    }
}

TEST_CASE("what the path is off by is added to it, between the middles of cells", "[isa]") {
  constexpr int kCols = 24, kY = 4;
  const Image<float> still(2, kRows, kCols), none(1, kRows, kCols);
  const PathAhead path{still.plane(0), still.plane(0), nullptr, nullptr, 0.5f, 1};
  Image<float> clipped(1, kRows, kCols), nowhere(1, 1, 3), off(2, 2, 3), to(2, kRows, kCols),
      from(2, kRows, kCols);
  clipped.fill(1), nowhere.fill(kNowhere);
  for (int cell = 0; cell < 3; ++cell)
    off.at(0, 0, cell) = static_cast<float>(cell), off.at(1, 0, cell) = -2 * static_cast<float>(cell);
  std::vector<float> measured(kCols);
  clipped_motion_kernels().bridge({{kRows, kCols, kY},
                                   clipped.row(0, kY),
                                   none.plane(0),
                                   path,
                                   nowhere.row(0, 0),
                                   nowhere.row(0, 0),
                                   still.plane(0),
                                   to.row(0, kY),
                                   to.row(1, kY),
                                   measured.data(),
                                   off.row(0, 0),
                                   off.row(1, 0)});
  clipped_motion_kernels().bridge_ahead({{kRows, kCols, kY},
                                         clipped.plane(0),
                                         none.plane(0),
                                         path,
                                         still.plane(0),
                                         from.row(0, kY),
                                         from.row(1, kY),
                                         off.plane(0)});
  for (int x = 0; x < kCols; ++x) {
    const float between = std::clamp((static_cast<float>(x) + 0.5f) / 8 - 0.5f, 0.f, 2.f);
    CAPTURE(x);
    CHECK(to.at(0, kY, x) == Approx(between).margin(kRounding));
    CHECK(to.at(1, kY, x) == Approx(-2 * between).margin(kRounding));
    CHECK(from.at(0, kY, x) == -static_cast<float>(x / 8));
    CHECK(from.at(1, kY, x) == 2 * static_cast<float>(x / 8));
  }
}

TEST_CASE("the state's pixels move over a frame that clips them as they do to the frame after it", "[isa]") {
  for (const int cols : {3, 8, 64, 83})
    for (const bool changes : {false, true}) {
      const Pictures pictures(cols);
      Image<float> motion = pictures.motion.clone();
      for (int y = 0; y < kRows; ++y)
        clipped_motion_kernels().bridge_ahead({{kRows, cols, y},
                                               pictures.clipped.plane(0),
                                               pictures.clipped_after.plane(0),
                                               pictures.path(changes),
                                               pictures.motion.plane(0),
                                               motion.row(0, y),
                                               motion.row(1, y)});
      Image<float> expected = pictures.motion.clone(), along(1, kRows, cols);
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < cols; ++x)
          along.at(0, y, x) = NearestPixel(cols, x, y, kShare * offset_at(pictures.state_to_after, x, y))
                                  .of(pictures.clipped, 0);
      at_clipped(along, 0.4f, 0.9f, [&](int x, int y, float clipped) {
        const Offset whole = offset_at(pictures.state_to_after, x, y);
        Offset ahead = kShare * whole;
        if (changes)
          ahead = ahead +
                  -1 * bend_of(whole, offset_at(pictures.last, x, y), pictures.measured_before.at(0, y, x));
        const float after = NearestPixel(cols, x, y, whole).of(pictures.clipped_after, 0);
        take_over(expected, x, y, clipped * (1 - smooth_step(0.1f, 0.6f, after)), ahead);
      });
      check(motion, expected);
    }
}

namespace {

// An object of 16 pixels that is at 8 in the state, and 32 further right in the frame after the clipped one.
constexpr float kFlight = 32;
struct Flight {
  static constexpr int kCols = 96;
  Image<float> state_to_after{2, kRows, kCols}, after_to_state{2, kRows, kCols}, none{1, kRows, kCols},
      landed{2, 1, kCols / kLandingCell};
  Flight() {
    for (int y = 0; y < kRows; ++y) {
      std::fill_n(state_to_after.row(0, y) + 8, 16, kFlight);
      std::fill_n(after_to_state.row(0, y) + 40, 16, -kFlight);
    }
    landed.fill(kNowhere);
    for (int cell = 2; cell < 6; ++cell) landed.at(0, 0, cell) = kFlight, landed.at(1, 0, cell) = 0;
  }
  PathAhead path() const {
    return {after_to_state.plane(0), state_to_after.plane(0), nullptr, nullptr, 0.5f, 1};
  }
  // Row y of the motion to the state, where the frame is clipped so far and its own motion back is `from`.
  void bridge(int y, const Image<float>& clipped, const Image<float>& from, Image<float>& motion) const {
    std::vector<float> measured(kCols);
    clipped_motion_kernels().bridge({{kRows, kCols, y},
                                     clipped.row(0, y),
                                     none.plane(0),
                                     path(),
                                     landed.row(0, 0),
                                     landed.row(1, 0),
                                     from.plane(0),
                                     motion.row(0, y),
                                     motion.row(1, y),
                                     measured.data()});
  }
};

}  // namespace

TEST_CASE("what moves fast over a clipped frame is where it lands", "[isa]") {
  const Flight flight;
  Image<float> clipped(1, kRows, Flight::kCols), still(2, kRows, Flight::kCols),
      motion(2, kRows, Flight::kCols);
  clipped.fill(1);
  for (int y = 0; y < kRows; ++y) flight.bridge(y, clipped, still, motion);
  for (const int x : {25, 30, 38}) CHECK(motion.at(0, 5, x) == Approx(-kFlight / 2).margin(kRounding));
  for (const int x : {2, 60, 90}) CHECK(motion.at(0, 5, x) == Approx(0).margin(kRounding));
}

TEST_CASE("what moves fast is believed against a frame's own motion that does not lead back", "[isa]") {
  const Flight flight;
  Image<float> lost(2, kRows, Flight::kCols), back(2, kRows, Flight::kCols);
  std::fill_n(lost.plane(0), lost.plane_size(), 5.f);
  const bool leads_back = GENERATE(false, true);
  if (leads_back) std::fill_n(back.plane(0), back.plane_size(), -5.f);
  Image<float> to = lost.clone(), from = lost.clone();
  for (int y = 0; y < kRows; ++y) {
    flight.bridge(y, flight.none, back, to);
    clipped_motion_kernels().bridge_ahead({{kRows, Flight::kCols, y},
                                           flight.none.plane(0),
                                           flight.none.plane(0),
                                           flight.path(),
                                           back.plane(0),
                                           from.row(0, y),
                                           from.row(1, y)});
  }
  CHECK(to.at(0, 5, 30) == Approx(leads_back ? 5 : -kFlight / 2).margin(kRounding));
  CHECK(from.at(0, 5, 14) == Approx(leads_back ? 5 : kFlight / 2).margin(kRounding));
  for (const int x : {2, 70}) {
    CHECK(to.at(0, 5, x) == 5);
    CHECK(from.at(0, 5, x) == 5);
  }
}

TEST_CASE("what moves fast is believed against a lost motion where a frame is clipped in part, too",
          "[isa]") {
  Flight flight;  // all of it is known from rest
  std::fill_n(flight.state_to_after.plane(0), flight.state_to_after.plane_size(), kFlight);
  std::fill_n(flight.after_to_state.plane(0), flight.after_to_state.plane_size(), -kFlight);
  Image<float> clipped(1, kRows, Flight::kCols), lost(2, kRows, Flight::kCols);
  clipped.fill(0.5f);
  std::fill_n(lost.plane(0), lost.plane_size(), 5.f);
  Image<float> to = lost.clone();
  for (int y = 0; y < kRows; ++y) flight.bridge(y, clipped, lost, to);
  for (const int x : {24, 30, 40}) CHECK(to.at(0, 5, x) == Approx(-kFlight / 2).margin(kRounding));
}

TEST_CASE("half of a motion's change is predicted to go on, less of a large one and none of a guess",
          "[isa]") {
  for (const int cols : {3, 8, 64, 83}) {
    const Pictures pictures(cols);
    const Image<float> measured = waves(1, cols, 0.96f, 0.04f, 8);
    Image<float> predicted(2, kRows, cols), expected(2, kRows, cols);
    for (int y = 0; y < kRows; ++y) {
      clipped_motion_kernels().predict({{kRows, cols, y},
                                        pictures.motion.row(0, y),
                                        pictures.motion.row(1, y),
                                        measured.row(0, y),
                                        pictures.last.plane(0),
                                        pictures.measured_before.plane(0),
                                        kRatio,
                                        predicted.row(0, y),
                                        predicted.row(1, y)});
      for (int x = 0; x < cols; ++x) {
        const Offset now = offset_at(pictures.motion, x, y);
        const NearestPixel there(cols, x, y, now);
        const Offset change = now + -kRatio * there.vector_of(pictures.last);
        const float sure = smooth_step(0.9f, 1, measured.at(0, y, x)) *
                           smooth_step(0.9f, 1, there.of(pictures.measured_before, 0));
        const Offset next = now + 0.5f * sure * limited(change, 1);
        expected.at(0, y, x) = next.x;
        expected.at(1, y, x) = next.y;
      }
    }
    check(predicted, expected);
  }
}
