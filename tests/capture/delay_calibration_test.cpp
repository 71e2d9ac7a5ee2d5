#include "capture/delay_calibration.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <string>
#include <string_view>

#include "hal/sim/simulated_camera.h"
#include "tests/capture/misbehaving_camera.h"
#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using test::MisbehavingCamera;
using test::SensorFaults;
using test::SensorKind;
using test::SensorSettings;
using namespace std::chrono_literals;

const std::atomic<bool> kGoOn{false};
constexpr Exposure kShort{3ms, 1}, kLong{12ms, 1}, kLongByGain{3ms, 4};

// Configures the camera.
DelayMeasurement measurement(Camera& camera, const Exposure& longer = kLong) {
  constexpr int kBuffers = 8;
  const StreamMode mode = camera.configure({}, kBuffers).value();
  return {.shorter = kShort, .longer = longer, .mode = mode, .buffers = kBuffers};
}

DelayEstimate measure(const SensorSettings& settings, const SensorFaults& faults,
                      const Exposure& longer = kLong) {
  MisbehavingCamera camera(settings, faults);
  const auto estimate = measure_delay(camera, measurement(camera, longer), kGoOn);
  REQUIRE(estimate.ok());
  return estimate.value();
}

TEST_CASE("every delay from 0 to 6 frames is measured, whatever the response", "[capture]") {
  for (const SensorKind kind : {SensorKind::RawBayer10, SensorKind::Gamma8, SensorKind::Film8}) {
    for (int latency = 0; latency <= 6; ++latency) {
      const DelayEstimate estimate = measure({.kind = kind, .per_request = false, .latency = latency}, {});
      CAPTURE(static_cast<int>(kind), latency, estimate.reason, estimate.agreement(), estimate.comparisons);
      CHECK(estimate.delay == latency);
      CHECK(estimate.confidence > 0.9999);
    }
  }
}

TEST_CASE("the delay of the gain is measured on its own", "[capture]") {
  const SensorSettings settings{.per_request = false, .latency = 2, .gain_latency = 1};
  CHECK(measure(settings, {}).delay == 2);
  CHECK(measure(settings, {}, kLongByGain).delay == 1);
}

TEST_CASE("a pan, unsteady light, cuts, lost frames and clipping do not mislead the calibration",
          "[capture]") {
  for (int latency = 0; latency <= 3; ++latency) {
    for (const SensorSettings& scene : {SensorSettings{.pan_px = 6}, SensorSettings{.light_walk = 0.08},
                                        SensorSettings{.cut = 0.05}, SensorSettings{.key = 5}}) {
      SensorSettings settings = scene;
      settings.per_request = false;
      settings.latency = latency;
      const DelayEstimate estimate = measure(settings, {.drop = 0.1});
      CAPTURE(latency, scene.pan_px, scene.light_walk, scene.cut, scene.key, estimate.reason,
              estimate.agreement());
      CHECK((!estimate.delay || *estimate.delay == latency));
      if (scene.cut == 0) CHECK(estimate.delay == latency);
    }
  }
}

TEST_CASE("frames that arrive damaged use up their requests, and mislead nobody", "[capture]") {
  for (int latency = 0; latency <= 3; ++latency) {
    const DelayEstimate estimate = measure({.per_request = false, .latency = latency}, {.damage = 0.2});
    CAPTURE(latency, estimate.reason, estimate.agreement());
    CHECK(estimate.delay == latency);
    CHECK(estimate.agreement() > 0.97);
  }
}

TEST_CASE("a camera that delivers damaged frames alone is told of as that, not as a scene too dark",
          "[capture]") {
  MisbehavingCamera camera({.per_request = false}, {.damage = 1});
  const auto estimate = measure_delay(camera, measurement(camera), kGoOn);
  require_error(estimate, ErrorCode::Corrupt);
  CHECK_THAT(estimate.error().message, Catch::Contains("check the camera's cable"));
}

TEST_CASE("exposures that the camera says were written late count neither for a delay nor against it",
          "[capture]") {
  for (int latency = 0; latency <= 3; ++latency) {
    const DelayEstimate estimate = measure({.per_request = false, .latency = latency}, {.written_late = 0.2});
    CAPTURE(latency, estimate.reason, estimate.agreement());
    CHECK(estimate.delay == latency);
    CHECK(estimate.agreement() > 0.97);
  }
}

TEST_CASE("pictures that cannot tell are said to be so", "[capture]") {
  const DelayEstimate dark = measure({.per_request = false, .key = 1e-4}, {});
  CHECK_FALSE(dark.delay);
  CHECK(dark.reason.find("too dark") != std::string::npos);
  const DelayEstimate clipped = measure({.per_request = false, .key = 1e4}, {});
  CHECK_FALSE(clipped.delay);
  const DelayEstimate stuck = measure({.per_request = false}, {.never_applied = true});
  CHECK_FALSE(stuck.delay);
  CHECK(stuck.reason.find("ignore the control") != std::string::npos);
}

TEST_CASE("no delay explains a larger share of the pictures than is said", "[capture]") {
  constexpr std::string_view kBefore = "no delay explains more than ";
  int said = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const DelayEstimate stuck = measure({.per_request = false, .light_walk = 0.08, .seed = seed},
                                        {.drop = 0.1, .never_applied = true});
    CAPTURE(seed, stuck.reason, stuck.agreed, stuck.comparisons);
    if (!stuck.reason.starts_with(kBefore)) continue;
    ++said;
    const int percent = std::stoi(stuck.reason.substr(kBefore.size()));
    CHECK(100 * stuck.agreed <= percent * stuck.comparisons);
    CHECK(100 * stuck.agreed > (percent - 1) * stuck.comparisons);
  }
  CHECK(said > 0);
}

TEST_CASE("a camera that loses most frames is given up after twice the time of a calibration", "[capture]") {
  MisbehavingCamera camera({.per_request = false}, {.drop = 1, .drop_run = 29});
  const DelayMeasurement how = measurement(camera);
  const auto estimate = measure_delay(camera, how, kGoOn);
  REQUIRE(estimate.ok());
  CHECK_FALSE(estimate.value().delay);
  CHECK(estimate.value().reason.find("frames are lost") != std::string::npos);
  CHECK(static_cast<int>(camera.frames()) <= 2 * how.frames + 2 * 30);
}

TEST_CASE("a camera with frames of some seconds is waited for", "[capture]") {
  VirtualClock clock;
  SimulatedCamera camera(value_of(simulation_of("still?size=64x48&delay=2")), SimTime(clock), 1);
  const StreamMode mode = value_of(camera.configure({PixelFormat::Rgb24, 64, 48, 3s}, 8));
  REQUIRE(mode.frame_duration > 2s);
  const DelayEstimate estimate = value_of(
      measure_delay(camera, {.shorter = kShort, .longer = kLong, .mode = mode, .buffers = 8}, kGoOn));
  CAPTURE(estimate.reason);
  CHECK(estimate.delay == 2);
}

TEST_CASE("a calibration that is told to stop ends at the next frame", "[capture]") {
  MisbehavingCamera camera({.per_request = false}, {});
  const std::atomic<bool> stop{true};
  const auto estimate = measure_delay(camera, measurement(camera), stop);
  REQUIRE_FALSE(estimate.ok());
  CHECK(estimate.error().code == ErrorCode::Interrupted);
  CHECK(camera.frames() <= 1);
}

}  // namespace
}  // namespace hdrcam
