#include "hal/core/sound_facts.h"

#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr PoseMatrix kHome{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

TEST_CASE("a lens has focal lengths in pixels and a centre near the picture") {
  const auto refused = [](Intrinsics lens) { return objection_to(lens, 320, 240).has_value(); };
  CHECK_FALSE(refused({300, 300, 160, 120}));
  CHECK_FALSE(refused({300, 310, -40, 500}));
  for (const double focal : {0., -300., 1e40, 0.8, kNan, HUGE_VAL}) {
    INFO(focal);
    CHECK(refused({focal, 300, 160, 120}));
    CHECK(refused({300, focal, 160, 120}));
  }
  for (const double centre : {1e9, -1e9, kNan, HUGE_VAL}) {
    INFO(centre);
    CHECK(refused({300, 300, centre, 120}));
    CHECK(refused({300, 300, 160, centre}));
  }
}

TEST_CASE("a pose is a rotation and a place on Earth") {
  CHECK_FALSE(objection_to(kHome));
  const double c = std::cos(0.3), s = std::sin(0.3);
  CHECK_FALSE(objection_to(PoseMatrix{c, 0, s, 12, 0, 1, 0, -3, -s, 0, c, 4e5}));
  PoseMatrix far = kHome, stretched = kHome, flat = kHome, mirrored = kHome, sheared = kHome, unknown = kHome;
  far[3] = 1e300, stretched[0] = 2, flat[10] = 0, mirrored[5] = -1, sheared[1] = 0.5, unknown[7] = kNan;
  for (const PoseMatrix& pose : {far, stretched, flat, mirrored, sheared, unknown}) CHECK(objection_to(pose));
}

TEST_CASE("frames come in the order of their numbers and of their times") {
  FrameFacts one, two;
  one.sequence = 4, one.timestamp = Instant::from_seconds(1);
  two.sequence = 5, two.timestamp = Instant::from_seconds(1.03);
  CHECK_FALSE(objection_to(one, nullptr));
  CHECK_FALSE(objection_to(two, &one));
  CHECK(objection_to(one, &two));
  CHECK(objection_to(one, &one));
  FrameFacts same_time = two;
  same_time.timestamp = one.timestamp;
  CHECK(objection_to(same_time, &one)->find("1.000000") != std::string::npos);
  FrameFacts same_number = two;
  same_number.sequence = 4;
  CHECK(objection_to(same_number, &one)->find("4") != std::string::npos);
}

TEST_CASE("a time is one of a clock, so that the difference of two fits 64 bits") {
  FrameFacts facts;
  for (const Duration far : {Duration::max(), Duration::min(), Duration(4'000'000'000'000'000'001)}) {
    facts.timestamp.since_boot = far;
    CHECK(objection_to(facts, nullptr));
  }
  facts.timestamp = Instant::from_seconds(1.76e9);  // today, since 1970
  CHECK_FALSE(objection_to(facts, nullptr));
}

TEST_CASE("an exposure lasts a day at most, and its gains are factors that a camera can have") {
  for (const double far : {86'401., 9.3e9, 1e300, HUGE_VAL}) {
    FrameFacts longer, brighter;
    longer.exposure_s = brighter.analogue_gain = far * 100;
    CHECK(objection_to(longer, nullptr)->find("exposure") != std::string::npos);
    CHECK(objection_to(brighter, nullptr)->find("gain") != std::string::npos);
  }
  FrameFacts night;
  night.exposure_s = 3600, night.analogue_gain = 640;
  CHECK_FALSE(objection_to(night, nullptr));
}

TEST_CASE("an exposure and its gains are not negative, and NaN or 0 where they are not known") {
  for (const double wrong : {-1e-9, -0.004, -1e300, -HUGE_VAL}) {
    INFO(wrong);
    FrameFacts exposed, amplified, scaled;
    exposed.exposure_s = amplified.analogue_gain = scaled.digital_gain = wrong;
    for (const auto& [facts, word] :
         {std::pair{exposed, "exposure"}, std::pair{amplified, "gain"}, std::pair{scaled, "gain"}}) {
      const auto objection = objection_to(facts, nullptr);
      REQUIRE(objection);
      CHECK(objection->find(word) != std::string::npos);
    }
  }
  for (const double unknown : {0., -0., kNan}) {
    INFO(unknown);
    FrameFacts facts;
    facts.exposure_s = facts.analogue_gain = facts.digital_gain = unknown;
    CHECK_FALSE(objection_to(facts, nullptr));
    CHECK_FALSE(facts.has_exposure());
  }
}

TEST_CASE("a black level is below the largest code, and a number") {
  FrameFacts facts;
  for (const double black : {kNan, HUGE_VAL, -0.5, 255., 4000.}) {
    facts.black_level = BlackLevel(black);
    INFO(black);
    CHECK(objection_to(facts, nullptr)->find("black level") != std::string::npos);
  }
  for (const double black : {0., 16., 254.}) {
    facts.black_level = BlackLevel(black);
    CHECK_FALSE(objection_to(facts, nullptr));
  }
}

TEST_CASE("a frame rate is one that a camera can have") {
  CameraFacts camera;
  camera.width = 320, camera.height = 240;
  for (const double rate_hz : {0., -30., 1e-300, 1e300, kNan, HUGE_VAL}) {
    camera.framerate_hz = rate_hz;
    CHECK(objection_to(camera)->find("frame rate") != std::string::npos);
  }
  camera.framerate_hz = 1000;
  CHECK_FALSE(objection_to(camera));
  camera.intrinsics = Intrinsics{1e40, 300, 160, 120};
  CHECK(objection_to(camera)->find("fx") != std::string::npos);
}

TEST_CASE("a white balance has gains that a camera can have") {
  CameraFacts camera;
  camera.width = 320, camera.height = 240;
  for (const double gain : {0., -1., 1e-3, 100., kNan, HUGE_VAL}) {
    camera.white_balance = ChannelGains{2, 1, gain};
    REQUIRE(objection_to(camera));
    CHECK(objection_to(camera)->find("white balance") != std::string::npos);
  }
  camera.white_balance = ChannelGains{2, 1, 1.5};
  CHECK_FALSE(objection_to(camera));
}

TEST_CASE("a response has three curves of 256 finite exposures that never fall") {
  CameraFacts camera;
  camera.width = 320, camera.height = 240;
  std::vector<double> curve(256);
  for (std::size_t code = 0; code < curve.size(); ++code) curve[code] = static_cast<double>(code / 2);
  camera.response = {curve, curve, curve};
  CHECK_FALSE(objection_to(camera));
  const auto objects = [&](std::initializer_list<const char*> words) {
    const auto objection = objection_to(camera);
    REQUIRE(objection);
    INFO(*objection);
    for (const char* word : words) CHECK(objection->find(word) != std::string::npos);
  };
  for (const double value : {kNan, HUGE_VAL, -1e-9, 1e300}) {
    camera.response = {curve, curve, curve};
    camera.response[1][77] = value;
    objects({"green", "77"});
  }
  camera.response = {curve, curve, curve};
  camera.response[2][200] -= 2;
  objects({"blue", "falls", "200"});
  camera.response = {curve, std::vector<double>(256), curve};
  objects({"green", "0 at every code"});
  camera.response = {curve, curve};
  objects({"2 curves"});
  camera.response = {curve, curve, {0, 1}};
  objects({"blue", "2 exposures", "256"});
}

}  // namespace
}  // namespace hdrcam
