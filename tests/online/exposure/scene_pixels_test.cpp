// What the forecast of exposures knows of motion: on waves that move to the right, whose next step a test
// chooses.
#include "online/exposure/scene_pixels.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "hal/sim/counter_random.h"
#include "online/pictures/between_pixels.h"
#include "tests/online/exposure/estimate_of.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 48, kCols = 64;
constexpr float kStep = 3.25f;  // pixels from the frame before

struct Waves {
  float length_px = 9;
  float noise = 0;  // of radiance
};

// Mean variance that a step adds to what is known, where the scene moves on like that; none: not known.
double misalignment(const Waves& waves, const std::function<Offset(int y)>& onwards,
                    const FusionOptions& fusion = {}) {
  ExposedFrame frame;
  frame.codes = Image<float>(3, kRows, kCols);
  frame.interval_s = 0.033;
  RadianceState state;
  state.radiance = Image<float>(3, kRows, kCols), state.variance = Image<float>(3, kRows, kCols);
  state.variance.fill(waves.noise * waves.noise);
  const FlowField flow = test::uniform_flow(kRows, kCols, -kStep);
  Image<float> to_next(2, kRows, kCols);
  const CounterRandom random(1, 2, 3);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      const float wave = std::sin(static_cast<float>(x) * 2 * std::numbers::pi_v<float> / waves.length_px);
      const auto pixel = static_cast<std::uint64_t>(y * kCols + x);
      for (int c = 0; c < 3; ++c)
        state.radiance.at(c, y, x) = 0.2f + 0.1f * wave + waves.noise * random.normals(pixel * 6 + 2 * c).a;
      const Offset next = onwards ? onwards(y) : Offset{};
      to_next.at(0, y, x) = next.x, to_next.at(1, y, x) = next.y;
    }
  const FrameEstimate estimate = test::estimate_of(frame, state, flow, onwards ? &to_next : nullptr, 1);
  ScenePixels pixels(fusion);
  while (!pixels.complete()) pixels.see(estimate);
  const ScenePixels::Values& values = pixels.misalignment();
  return std::accumulate(values.begin(), values.end(), 0.0) / ScenePixels::kPixels;
}

}  // namespace

TEST_CASE(
    "what moves on otherwise than it came is followed badly, and uneven distances of frames are no turn") {
  const double alone = misalignment({}, nullptr);
  REQUIRE(alone > 0);
  CHECK(misalignment({}, [](int) { return Offset{kStep, 0}; }) == Approx(alone).epsilon(0.01));
  CHECK(misalignment({}, [](int) { return Offset{1.8f * kStep, 0}; }) == Approx(alone).epsilon(0.01));
  // across the waves nothing slips
  CHECK(misalignment({}, [](int) { return Offset{kStep, 3}; }) == Approx(alone).epsilon(0.01));
  const auto turned = [](int y) { return Offset{kStep + (y % 8 < 4 ? 2.f : -2.f), 0}; };
  CHECK(misalignment({}, turned) > 100 * alone);
}

TEST_CASE("a step adds as much to what is known as the state adds, whatever its knob says") {
  const double usual = misalignment({}, nullptr);
  REQUIRE(usual > 0);
  CHECK(misalignment({}, nullptr, {.misalignment = 2 * FusionOptions().misalignment}) ==
        Approx(4 * usual).epsilon(1e-5));
  CHECK(misalignment({}, nullptr, {.misalignment = 0}) == 0);
}

TEST_CASE("noise of the state is no slip, however unsteady the motion") {
  const Waves flat{.length_px = 1e6f, .noise = 0.02f};
  const auto turned = [](int y) { return Offset{kStep + (y % 8 < 4 ? 2.f : -2.f), 0}; };
  // of Gaussian noise some differences are larger than expected, and only those can count
  CHECK(misalignment(flat, turned) < 20 * flat.noise * flat.noise);
}
