// The effects on light, each against its formula.
#include <numbers>

#include "hal/sim/effects/distortion.h"
#include "hal/sim/effects/flare.h"
#include "hal/sim/effects/mains_flicker.h"
#include "hal/sim/effects/motion_blur.h"
#include "hal/sim/effects/rolling_shutter.h"
#include "hal/sim/effects/vignetting.h"
#include "hal/sim/lens.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("distortion moves a ray by its polynomial, and back") {
  const Distortion lens({.k1 = -0.12f, .k2 = 0.02f});
  const Vec2 seen = lens.distorted({0.3f, 0.4f});  // r = 0.5
  CHECK(seen.x == Approx(0.3 * (1 - 0.12 * 0.25 + 0.02 * 0.0625)));
  CHECK(seen.y == Approx(0.4 * (1 - 0.12 * 0.25 + 0.02 * 0.0625)));
  for (float x = -0.7f; x <= 0.7f; x += 0.1f)
    for (float y = -0.5f; y <= 0.5f; y += 0.1f) {
      const Vec2 back = lens.undistorted(lens.distorted({x, y}));
      CHECK(back.x == Approx(x).margin(1e-6));
      CHECK(back.y == Approx(y).margin(1e-6));
    }
}

TEST_CASE("distortion has its inverse in the corners of a picture that is taller than wide") {
  const Distortion lens({.k1 = -0.12f, .k2 = 0.02f});
  for (const float y : {1.0f, 1.2f, 1.4f, 1.7f, 2.5f, 8.f}) {
    const Vec2 seen = lens.distorted(lens.undistorted({-1, y}));
    CHECK(seen.x == Approx(-1).epsilon(1e-5));
    CHECK(seen.y == Approx(y).epsilon(1e-5));
  }
}

TEST_CASE("vignetting follows the fourth power of the cosine") {
  const Intrinsics lens = centred_intrinsics(64, 48, std::numbers::pi / 3);
  const Vignetting natural({.strength = 1}, lens, 48, 64), wide_open({.strength = 2}, lens, 48, 64);
  const double dx = (0.5 - 32) / lens.fx_px, dy = (0.5 - 24) / lens.fy_px;
  const double cosine = 1 / std::sqrt(1 + dx * dx + dy * dy);
  CHECK(natural.factor(0, 0) == Approx(std::pow(cosine, 4)));
  CHECK(wide_open.factor(0, 0) == Approx(std::pow(cosine, 8)));
  CHECK(natural.factor(24, 32) == Approx(1).margin(1e-3));
  Image<float> light(3, 48, 64);
  light.fill(2);
  natural.apply_row(light, 0);
  CHECK(light.at(1, 0, 0) == Approx(2 * std::pow(cosine, 4)));
  CHECK(light.at(1, 1, 0) == 2);
}

TEST_CASE("flare scatters its share of a point into a halo and loses none of it") {
  WorkerPool pool(2);
  Flare flare({.strength = 0.1f, .reach = 0.05f}, 240, 320);
  Image<float> light(3, 240, 320);
  light.at(0, 120, 160) = 1000;
  flare.apply(light, pool);
  double sum = 0;
  for (const float value : light.samples()) sum += static_cast<double>(value);
  CHECK(sum == Approx(1000).epsilon(1e-3));
  CHECK(light.at(0, 120, 160) == Approx(900).epsilon(0.01));
  CHECK(light.at(0, 120, 170) > 0);                      // a halo..
  CHECK(light.at(0, 120, 170) > light.at(0, 120, 190));  // that falls off
  CHECK(light.at(0, 10, 10) == 0);                       // and ends
  CHECK(light.at(1, 120, 170) == 0);                     // each colour for itself
}

TEST_CASE("flare leaves an even picture as it is, whatever its size") {
  WorkerPool pool(1);
  for (const int cols : {16, 37, 100}) {
    Flare flare({.strength = 0.3f, .reach = 0.1f}, 29, cols);
    Image<float> light(3, 29, cols);
    light.fill(0.25f);
    flare.apply(light, pool);
    for (const float value : light.samples()) REQUIRE(value == Approx(0.25f).epsilon(1e-5));
  }
}

TEST_CASE("mains flicker is the mean of the lamp's pulse over the exposure") {
  const MainsFlicker flicker({.mains_hz = 50, .modulation = 0.3});
  for (const double begin_s : {0.0, 0.0013, 0.017})
    for (const double exposure_s : {0.0005, 0.004, 0.013}) {
      double sum = 0;
      constexpr int kSteps = 20'000;
      for (int i = 0; i < kSteps; ++i) {
        const double t = begin_s + exposure_s * (i + 0.5) / kSteps;
        sum += 1 + 0.3 * std::cos(4 * std::numbers::pi * 50 * t);
      }
      CHECK(flicker.factor(begin_s, exposure_s) == Approx(sum / kSteps).margin(1e-5));
    }
}

TEST_CASE("an exposure of whole half periods of the mains does not flicker") {
  const MainsFlicker flicker({.mains_hz = 50, .modulation = 1});
  for (const double begin_s : {0.0, 0.0031, 0.0177}) {
    CHECK(flicker.factor(begin_s, 0.010) == Approx(1).margin(1e-6));
    CHECK(flicker.factor(begin_s, 0.020) == Approx(1).margin(1e-6));
  }
  CHECK(std::abs(flicker.factor(0, 0.001) - 1) > 0.5);
}

TEST_CASE(
    "motion blur takes one sample where nothing moves half a pixel, more as the way grows, and not without "
    "end") {
  const MotionBlur blur({.most_samples = 16});
  CHECK(blur.samples(0) == 1);
  CHECK(blur.samples(0.5f) == 1);
  CHECK(blur.samples(0.6f) == 4);
  CHECK(blur.samples(4) == 4);
  CHECK(blur.samples(4.1f) == 8);
  CHECK(blur.samples(1e6f) == 16);
  CHECK(MotionBlur::fraction(0, 4) == 0.125);
  CHECK(MotionBlur::fraction(3, 4) == 0.875);
}

TEST_CASE("a rolling shutter delays each row by its share of the readout") {
  const RollingShutter shutter({.readout = std::chrono::milliseconds(12)}, 240);
  CHECK(shutter.delay_s(0) == 0);
  CHECK(shutter.delay_s(120) == Approx(0.006));
  CHECK(shutter.delay_s(240) == Approx(0.012));
}
