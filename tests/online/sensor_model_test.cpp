// What the online stage learns of the sensor from the stream itself: its response and its noise.
#include "online/sensor_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "hal/core/median.h"
#include "online/response/response_estimator.h"
#include "online/state/state_layer.h"
#include "render/emission.h"
#include "tests/online/online_stream.h"
#include "tests/support/moving_scene.h"
#include "tests/support/response_error.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::OnlineStream;
using test::response_error;
using test::state_alone;

namespace {

// Whose noise, shared by the channels, single frames do not tell from texture.
test::MovingScene still_in_grey_noise() {
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128, scene.detail = 0.2;
  scene.drift_px = scene.disc_px = 0;
  scene.full_well = 1000, scene.read_noise = 10;
  scene.noise_is_grey = true;
  return scene;
}

// What lamps on the mains make of frames in a row.
constexpr std::array<double, 6> kLamps{1.25, 0.8, 1, 0.85, 1.2, 0.95};

}  // namespace

TEST_CASE("the first frames tell the noise of a sensor whose exposures share hardly a code") {
  test::MovingScene scene;
  scene.rows = 192, scene.cols = 256, scene.detail = 0.15;
  scene.exposures_s = {0.0005, 0.016};
  scene.gamma = 3;
  scene.full_well = 3000, scene.read_noise = 15;
  WorkerPool pool(2);
  const Knobs options = state_alone();
  OnlineStream stream(scene.camera(), options, pool);
  NoiseOrigin origin{};
  const auto emit = [&](const FrameEstimate& estimate) -> Result<void> {
    origin = estimate.noise_origin;
    return {};
  };
  for (int i = 0; i < 7; ++i) REQUIRE(stream.take(scene.frame(i), options.budget, emit).ok());
  CHECK(origin == NoiseOrigin::Sensor);
  CHECK(stream.online().sensor().noise().full_well == Approx(3000).epsilon(0.15));
  CHECK(stream.online().sensor().noise().read_noise == Approx(15).epsilon(0.25));
}

TEST_CASE("a response that the sensor's noise alone told is measured") {
  test::MovingScene scene;
  scene.rows = 192, scene.cols = 256, scene.detail = 0.15;
  scene.exposures_s = {0.004};  // no two that could be compared
  scene.gamma = 1;
  scene.full_well = 3000, scene.read_noise = 15;
  WorkerPool pool(2);
  const Knobs options = state_alone();
  OnlineStream stream(scene.camera(), options, pool);
  const auto emit = [](const FrameEstimate&) -> Result<void> { return {}; };
  for (int i = 0; i < 7; ++i) REQUIRE(stream.take(scene.frame(i), options.budget, emit).ok());
  const SensorModel& sensor = stream.online().sensor();
  CHECK(sensor.response_measured());
  CHECK(response_error(sensor.response(), Response::linear()) <
        0.5 * response_error(prior_mean_response(), Response::linear()));
}

TEST_CASE("under lamps that flicker the response is found, and each frame is exposed as its own light says") {
  constexpr int kFrames = 30;
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128;
  const double sensitivity = scene.sensitivity;
  WorkerPool pool(2);
  Knobs options = state_alone();
  options.light = GENERATE(LightKind::Followed, LightKind::Steady);
  OnlineStream stream(scene.camera(), options, pool);
  std::vector<double> off;  // ln, exposures that count over true ones
  const auto emit = [&](const FrameEstimate& estimate) -> Result<void> {
    const auto i = static_cast<std::size_t>(estimate.frame.index);
    const double truth = scene.exposures_s[i % 3] * kLamps[i % 6] / estimate.reference_exposure;
    off.push_back(std::log(static_cast<double>(estimate.frame.exposure) / truth));
    return {};
  };
  for (int i = 0; i < kFrames; ++i) {
    scene.sensitivity = sensitivity * kLamps[static_cast<std::size_t>(i) % 6];
    REQUIRE(stream.take(scene.frame(i), options.budget, emit).ok());
  }
  REQUIRE(stream.finish(options.budget, emit).ok());
  REQUIRE(off.size() == kFrames);
  const auto [least, most] = std::ranges::minmax_element(off);
  const double error = response_error(stream.online().sensor().response(), Response::gamma(scene.gamma));
  CAPTURE(error);
  if (options.light == LightKind::Steady) {
    CHECK(*most - *least > 0.4);
    CHECK(error > 0.1);
  } else {
    CHECK(*most - *least < 0.2);
    CHECK(error < 0.06);
    CHECK(stream.online().sensor().light_spread_stops() > 0.1);
  }
}

TEST_CASE("a gain over that of the first frame makes a sample as noisy as so much fewer electrons do") {
  const test::MovingScene scene;
  const Response response = Response::gamma(scene.gamma);
  WorkerPool pool(1);
  const auto state = make_state_layer({}, scene.rows, scene.cols, pool, nullptr);
  for (const double first_gain : {1.0, 2.5}) {
    SensorModel sensor(state_alone(), scene.camera(), response, *state, pool);
    const auto frame_at = [&](double gain) {  // all of one exposure
      ExposedFrame frame;
      frame.facts.exposure_s = 0.004 * first_gain / gain;
      frame.facts.analogue_gain = gain;
      return frame;
    };
    const ExposedFrame usual = frame_at(first_gain), amplified = frame_at(4 * first_gain);
    sensor.meet(usual);
    NoiseModel quarter = sensor.noise();
    quarter.full_well /= 4;
    const ExposureTables of_all(response, sensor.noise(), 1), of_quarter(response, quarter, 1);
    for (const float x : {0.01f, 0.1f, 0.5f}) {
      CAPTURE(first_gain, x);
      CHECK(sensor.tables_for(usual).variance(1, x) == Approx(of_all.variance(1, x)));
      CHECK(sensor.tables_for(amplified).variance(1, x) == Approx(of_quarter.variance(1, x)));
    }
    // where the noise of codes is the least part
    CHECK(sensor.tables_for(amplified).variance(1, 0.01f) > 4 * sensor.tables_for(usual).variance(1, 0.01f));
  }
}

TEST_CASE("noise that single frames do not tell is learned from pairs of them") {
  test::MovingScene scene = still_in_grey_noise();
  WorkerPool pool(2);
  const Knobs options = state_alone();
  OnlineStream stream(scene.camera(), options, pool);
  NoiseOrigin origin = NoiseOrigin::Sensor;
  const auto emit = [&](const FrameEstimate& estimate) -> Result<void> {
    origin = estimate.noise_origin;
    return {};
  };
  CHECK_FALSE(stream.online().sensor().noise_measured());
  for (int i = 0; i < 9; ++i) REQUIRE(stream.take(scene.frame(i), options.budget, emit).ok());
  CHECK(origin == NoiseOrigin::Unknown);
  CHECK(stream.online().sensor().noise_measured());
  CHECK(stream.online().sensor().noise().full_well > 500);
  CHECK(stream.online().sensor().noise().full_well < 2000);
}

TEST_CASE("each frame of a cycle tells of the noise again and again, however many the cycle has") {
  const test::MovingScene scene;
  WorkerPool pool(1);
  const Knobs options = state_alone();
  const auto state = make_state_layer(options.state, scene.rows, scene.cols, pool, nullptr);
  const SensorModel sensor(options, scene.camera(), Response::gamma(scene.gamma), *state, pool);
  for (int slots = 1; slots <= 6; ++slots) {
    std::vector<int> looks(static_cast<std::size_t>(slots));
    ExposedFrame frame;
    for (frame.index = 100; frame.index < 700; ++frame.index)
      if (sensor.learns_noise(frame)) ++looks[static_cast<std::size_t>(frame.index % slots)];
    for (const int count : looks) CHECK(count * slots >= 90);
  }
}

TEST_CASE("under a known response the black level is the first frame's, which is removed of all") {
  const test::MovingScene scene;
  WorkerPool pool(1);
  const Knobs options = state_alone();
  OnlineStage online(options, scene.camera(), Response::gamma(scene.gamma), pool);
  ExposedStream exposed(scene.camera(), options.bootstrap_frames, StatedBlack::Removed);
  const auto ignore = [](const FrameEstimate&) -> Result<void> { return {}; };
  for (int i = 0; i < 8; ++i) {
    RawFrame raw = scene.frame(i);
    raw.facts.black_level = BlackLevel(i == 0 ? 4 : 16);
    REQUIRE(exposed.take(raw, [&](ExposedFrame& frame) { return online.ingest(frame, {}, ignore); }).ok());
  }
  CHECK(online.sensor().camera_black_level() == BlackLevel(4));
}

TEST_CASE("of a camera that clips below the largest code the response is found up to where it clips") {
  constexpr double kWhite = 204, kShare = kWhite / 255;
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128, scene.sensitivity = 700;
  WorkerPool pool(1);
  const Knobs options = state_alone();
  OnlineStage online(options, scene.camera(), std::nullopt, pool);
  ExposedStream exposed(scene.camera(), options.bootstrap_frames, StatedBlack::Kept);
  const auto ignore = [](const FrameEstimate&) -> Result<void> { return {}; };
  for (int i = 0; i < 8; ++i) {
    RawFrame raw = scene.frame(i);
    for (std::uint16_t& code : raw.codes.samples())
      code = static_cast<std::uint16_t>(std::lround(kShare * code));
    REQUIRE(exposed.take(raw, [&](ExposedFrame& frame) { return online.ingest(frame, {}, ignore); }).ok());
  }
  const SensorModel& sensor = online.sensor();
  for (std::size_t c = 0; c < 3; ++c) CHECK(sensor.camera_white_level()[c] == Approx(kWhite).margin(1));
  const auto light_at = [&](double code) {
    return std::pow(static_cast<double>(sensor.camera_response().exposure_of(1, static_cast<float>(code))) /
                        static_cast<double>(sensor.camera_response().exposure_of(1, 100)),
                    1 / static_cast<double>(scene.gamma));
  };
  for (const double code : {50.0, 150.0, 190.0}) CHECK(light_at(code) == Approx(code / 100).epsilon(0.05));
  CHECK(sensor.camera_response().exposure_of(1, kWhite) == Approx(1).epsilon(0.01));
}

TEST_CASE("of a camera that clips below the largest code the black level is the one that it states") {
  constexpr double kBlack = 16, kWhite = 204;
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128;
  constexpr double kSensitivity = 700;
  const bool lamps_flicker = GENERATE(false, true);
  CAPTURE(lamps_flicker);
  WorkerPool pool(1);
  const Knobs options = state_alone();
  OnlineStream stream(scene.camera(), options, pool);
  const auto ignore = [](const FrameEstimate&) -> Result<void> { return {}; };
  for (int i = 0; i < 8; ++i) {
    scene.sensitivity =
        kSensitivity * (lamps_flicker ? kLamps[static_cast<std::size_t>(i) % kLamps.size()] : 1);
    RawFrame raw = scene.frame(i);
    raw.facts.black_level = BlackLevel(kBlack);
    for (std::uint16_t& code : raw.codes.samples())
      code = static_cast<std::uint16_t>(std::lround(kBlack + (kWhite - kBlack) / 255 * code));
    REQUIRE(stream.take(raw, options.budget, ignore).ok());
  }
  const SensorModel& sensor = stream.online().sensor();
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(sensor.camera_white_level()[c] == Approx(kWhite).margin(1));
    CHECK(sensor.camera_black_level()[c] == Approx(kBlack).margin(0.01));
  }
}

TEST_CASE("of a lens that is covered at first the response is learned when it no longer is") {
  test::MovingScene scene;
  scene.rows = 72, scene.cols = 96;
  scene.drift_px = 0.4, scene.disc_px = 0.8;
  scene.covered_frames = 14;
  constexpr int kFrames = 66;
  for (const int look_ahead : {0, 1, 2})
    for (const FieldKind field : {FieldKind::None, FieldKind::HashGrid}) {
      if (field != FieldKind::None && look_ahead != 1) continue;
      Knobs options = state_alone();
      options.look_ahead = look_ahead, options.field = field;
      WorkerPool pool(2);
      OnlineStream stream(scene.camera(), options, pool);
      Emission emission(pool);
      HdrFrame frame;
      std::vector<std::uint64_t> sequences;
      const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
        emission.render(estimate, frame);
        for (const float l : frame.radiance.samples()) REQUIRE((std::isfinite(l) && l >= 0));
        sequences.push_back(frame.facts.sequence);
        const std::vector<int>& anew = stream.online().sensor().relearned();
        if (look_ahead == 0 && !anew.empty() && estimate.frame.index == anew.front()) {
          const auto own = estimate.own_share.samples();
          std::vector<float> shares(own.begin(), own.end());
          CHECK(median(shares) > 0.99f);  // nothing of before is in it
        }
        return {};
      };
      const Response truth = Response::gamma(scene.gamma);
      double error_before = 0;
      for (int i = 0; i < kFrames; ++i) {
        REQUIRE(stream.take(scene.frame(i), options.budget, emit).ok());
        if (stream.online().sensor().relearned().empty())
          error_before = response_error(stream.online().sensor().response(), truth);
      }
      REQUIRE(stream.finish(options.budget, emit).ok());

      REQUIRE(sequences.size() == kFrames);
      for (std::size_t i = 0; i < kFrames; ++i) CHECK(sequences[i] == i);
      CHECK(stream.online().sensor().relearned().size() == 1);
      CHECK(error_before > 0.2);
      CHECK(response_error(stream.online().sensor().response(), truth) < 0.07);
    }
}

TEST_CASE("under another response the noise is learned as fast as at the beginning") {
  test::MovingScene scene = still_in_grey_noise();
  scene.covered_frames = 14;
  WorkerPool pool(2);
  const Knobs options = state_alone();
  OnlineStream stream(scene.camera(), options, pool);
  const auto ignore = [](const FrameEstimate&) -> Result<void> { return {}; };
  int frame = 0;
  for (; frame < 80 && stream.online().sensor().relearned().empty(); ++frame)
    REQUIRE(stream.take(scene.frame(frame), options.budget, ignore).ok());
  REQUIRE(stream.online().sensor().relearned().size() == 1);
  for (const int end = frame + 9; frame < end; ++frame)
    REQUIRE(stream.take(scene.frame(frame), options.budget, ignore).ok());
  CHECK(stream.online().sensor().noise().full_well > 500);
  CHECK(stream.online().sensor().noise().full_well < 2000);
}

TEST_CASE("a response that later frames show no better stays as it is, however long the stream") {
  test::MovingScene scene;
  scene.rows = 72, scene.cols = 96;
  scene.drift_px = 0.4, scene.disc_px = 0.8;
  scene.exposures_s = {0.0001, 0.016};  // which share hardly a code
  scene.noise_is_grey = true;
  const Knobs options = state_alone();
  WorkerPool pool(2);
  OnlineStream stream(scene.camera(), options, pool);
  const auto ignore = [](const FrameEstimate&) -> Result<void> { return {}; };
  for (int i = 0; i < 90; ++i) REQUIRE(stream.take(scene.frame(i), options.budget, ignore).ok());
  CHECK(uncertainty_of(stream.online().sensor().response()) > 0.06);  // so that it is looked at again
  CHECK(stream.online().sensor().relearned().empty());
}
