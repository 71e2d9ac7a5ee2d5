// How much light a frame has beside the state, and when that counts as its exposure.
#include "online/state/frame_light.h"

#include <array>
#include <cmath>

#include "tests/online/state/known_scene.h"
#include "tests/support/coded_frame.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 72, kCols = 96, kShift = 2;
constexpr std::array<float, 3> kExposures{0.5f, 1, 2};

// What lamps make of the frames of a cycle of three, which lasts half of their period: ln.
float lamps_at(int frame) { return 0.2f * static_cast<float>(std::sin(frame * 1.05)); }

float light(int c, int y, int x) {
  return 0.1f + 0.05f * static_cast<float>(std::sin(0.3 * x + c) * std::sin(0.2 * y));
}

// A state that knows a scene, and frames of it.
struct Lit {
  RadianceState state = test::known_scene(kRows, kCols, light);
  FlowField motion = test::uniform_flow(kRows, kCols, kShift);
  FrameLight seen;

  // The exposure's factor, ln, of a frame in this light, ln over the state's. covered: of the picture, by
  // something eight times as bright.
  float follow(int number, float in_light, double covered = 0) {
    const float exposure = kExposures[static_cast<std::size_t>(number) % kExposures.size()];
    const ExposureTables tables(Response::gamma(2.2f), {}, exposure);
    ExposedFrame frame = test::coded_frame(kRows, kCols, [&](int c, int y, int x) {
      const float more = (x < covered * kCols ? 8 : 1) * std::exp(in_light);
      return std::round(tables.code(c, more * light(c, y, x + kShift)));
    });
    frame.exposure = exposure;
    return seen.follow({frame, state, motion, tables, unseen_variance_from(4)});
  }
};

}  // namespace

TEST_CASE("light that goes up and down from frame to frame counts as exposure once that is seen") {
  Lit lit;
  for (int i = 0; i < 6; ++i) CHECK(lit.follow(i, lamps_at(i)) == 0);
  for (int i = 6; i < 30; ++i) lit.follow(i, lamps_at(i));
  CHECK(lit.seen.unsteady());
  for (int i = 30; i < 42; ++i) CHECK(lit.follow(i, lamps_at(i)) == Approx(lamps_at(i)).margin(0.03));
  CHECK(lit.follow(42, lamps_at(42), 0.3) == Approx(lamps_at(42)).margin(0.03));
  CHECK(lit.seen.spread_stops() == Approx(0.2 / std::sqrt(2) / std::log(2)).margin(0.06));
}

TEST_CASE("light that is expected to be unsteady counts as exposure from the first frame on") {
  Lit lit;
  lit.seen.expect_unsteady();
  for (int i = 0; i < 12; ++i) CHECK(lit.follow(i, lamps_at(i)) == Approx(lamps_at(i)).margin(0.05));
  for (int i = 12; i < 48; ++i) lit.follow(i, 0);
  CHECK_FALSE(lit.seen.unsteady());
  CHECK(lit.follow(48, 0.2f) == 0);
}

TEST_CASE("light that is switched on, changes slowly or is always off at one exposure is left as it is") {
  Lit lit;
  constexpr std::array<float, 5> kSwitchedOn{0.7f, 0.5f, 0.35f, 0.2f, 0.1f};  // until the state has followed
  const auto steady = [](int i) { return i % 3 == 0 ? 0.15f : 0.f; };
  for (int i = 0; i < 24; ++i) CHECK(lit.follow(i, steady(i)) == 0);
  for (int i = 24; i < 29; ++i)
    CHECK(lit.follow(i, steady(i) + kSwitchedOn[static_cast<std::size_t>(i - 24)]) == 0);
  for (int i = 29; i < 60; ++i) CHECK(lit.follow(i, steady(i) + 0.01f) == 0);
  CHECK(lit.seen.spread_stops() == 0);
}

TEST_CASE("light that changes for good while lamps flicker is followed within seconds") {
  Lit lit;
  lit.seen.expect_unsteady();
  for (int i = 0; i < 30; ++i) lit.follow(i, lamps_at(i));
  for (int i = 30; i < 150; ++i) lit.follow(i, lamps_at(i) + 0.4f);
  for (int i = 150; i < 156; ++i)
    CHECK(lit.follow(i, lamps_at(i) + 0.4f) == Approx(lamps_at(i)).margin(0.05));
}

TEST_CASE("a frame that shows nothing of what the state knows tells no light") {
  Lit lit;
  lit.seen.expect_unsteady();
  CHECK(lit.follow(0, -6) == 0);  // all black
  lit.state.variance.fill(unseen_variance_from(4));
  CHECK(lit.follow(1, 0.2f) == 0);
}
