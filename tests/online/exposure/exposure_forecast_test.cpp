// The error that is forecast of a cycle, on a pattern that moves.
#include "online/exposure/exposure_forecast.h"

#include <chrono>
#include <cmath>
#include <numbers>

#include "tests/online/exposure/estimate_of.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace std::chrono_literals;

namespace {

// Of a cycle of 1, 4 and 16 ms, for a state with these options.
double forecast_error(const StateOptions& options) {
  constexpr int kRows = 48, kCols = 64;
  constexpr float kNoise = 0.002f, kStep_px = 3.25f, kWave_px = 7;
  constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};
  ExposedFrame frame;
  frame.codes = Image<float>(3, kRows, kCols);
  frame.interval_s = 0.033;
  RadianceState state;
  state.radiance = Image<float>(3, kRows, kCols), state.variance = Image<float>(3, kRows, kCols);
  state.variance.fill(kNoise * kNoise);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x)
        state.radiance.at(c, y, x) =
            0.15f + 0.07f * std::sin(static_cast<float>(x) * 2 * std::numbers::pi_v<float> / kWave_px);
  const FlowField flow = test::uniform_flow(kRows, kCols, -kStep_px);
  const double reference_exposure = kCycle[1].product();
  const FrameEstimate estimate = test::estimate_of(frame, state, flow, nullptr, reference_exposure);
  ScenePixels pixels(options.fusion);
  while (!pixels.complete()) pixels.see(estimate);
  const Response response = Response::gamma(2.2f);
  const NoiseModel noise;
  ExposureForecast forecast(options);
  forecast.look(pixels, {response, noise, 1}, reference_exposure, test::kWhite);
  return forecast.error(kCycle, ExposureForecast::Blur::Counted);
}

}  // namespace

TEST_CASE("what the state is told of noise, of forgetting and of motion counts in the forecast, too") {
  const double usual = forecast_error({});
  REQUIRE(usual > 0);
  CHECK(forecast_error({.fusion = {.relative_noise = 0.1f}}) > 1.01 * usual);
  CHECK(forecast_error({.fusion = {.misalignment = 4}}) > 1.01 * usual);
  CHECK(forecast_error({.fusion = {}, .variance_growth = 1}) > 1.01 * usual);
  CHECK(forecast_error({.fusion = {}, .relative_growth = 0.2f}) > 1.01 * usual);
}
