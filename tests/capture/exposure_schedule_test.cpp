#include "capture/exposure_schedule.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Duration k30Hz{33'333'333};
constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}, {16ms, 2}};

CameraCapabilities sensor() {
  CameraCapabilities camera;
  camera.id = "sensor";
  camera.exposure_min = 10us, camera.exposure_max = 60ms, camera.exposure_step = 10us;
  camera.gain_max = 8;
  return camera;
}

TEST_CASE("requests walk through the cycle", "[capture]") {
  const auto schedule = ExposureSchedule::create(kCycle, sensor(), k30Hz);
  REQUIRE(schedule.ok());
  CHECK(schedule.value().slots() == 3);
  CHECK(schedule.value().slot_of(7) == 1);
  CHECK(schedule.value().exposure_of(8) == kCycle[2]);
}

TEST_CASE("an exposure that does not fit the frame is refused with what would do", "[capture]") {
  constexpr Exposure kLong[] = {{1ms, 1}, {33ms, 1}};
  const auto schedule = ExposureSchedule::create(kLong, sensor(), k30Hz);
  REQUIRE_FALSE(schedule.ok());
  CHECK(schedule.error().code == ErrorCode::BadExposure);
  CHECK(schedule.error().message.find("--framerate to 29.86") != std::string::npos);
  CHECK(ExposureSchedule::create(kLong, sensor(), Duration(1'000'000'000 / 29)).ok());

  // No advice that would be refused in turn: not beyond the sensor's longest, nor below the least rate.
  constexpr Exposure kBeyond[] = {{1ms, 1}, {4s, 1}};
  CHECK(ExposureSchedule::create(kBeyond, sensor(), k30Hz).error().message ==
        "shutter 4 s does not fit a frame of 33.33 ms with 480 us of read-out; shorten it to 32.85 ms");
  constexpr Exposure kSlow[] = {{1ms, 1}, {10s, 1}};
  CameraCapabilities patient = sensor();
  patient.exposure_max = 20s;
  CHECK(ExposureSchedule::create(kSlow, patient, 10s).error().message ==
        "shutter 10 s does not fit a frame of 10 s with 480 us of read-out; shorten it to 9.999 s");
  CameraCapabilities quick = sensor();
  quick.exposure_max = 30'333us;
  CHECK(ExposureSchedule::create(kLong, quick, k30Hz).error().message.find("shorten it to 30.33 ms") !=
        std::string::npos);

  const Exposure five[5] = {{1ms, 1}, {1ms, 1}, {1ms, 1}, {1ms, 1}, {1ms, 1}};
  CHECK_FALSE(ExposureSchedule::create(five, sensor(), k30Hz).ok());
  CHECK_FALSE(ExposureSchedule::create({}, sensor(), k30Hz).ok());
}

TEST_CASE("a time rounded down is printed in full, and never longer", "[capture]") {
  for (const Duration time : {Duration(32'853'333), Duration(9'999'520'000), Duration(250'000)}) {
    const Duration typed = rounded_down(time);
    CAPTURE(describe(typed));
    CHECK(typed <= time);
    CHECK(typed > time - time / 1000);
    CHECK(parse_duration(describe(typed)).value() == typed);
  }
}

TEST_CASE("a cycle of several equal exposures is refused, also where the sensor or the mains make them equal",
          "[capture]") {
  const Exposure equal[] = {{1ms, 1}, {1ms, 1}, {1ms, 1}}, nearly[] = {{11ms, 1}, {14ms, 1}};
  CHECK_FALSE(ExposureSchedule::create(equal, sensor(), k30Hz).ok());
  CHECK(ExposureSchedule::create(nearly, sensor(), k30Hz).ok());
  const auto at_mains = ExposureSchedule::create(nearly, sensor(), k30Hz, Mains::Hz50);
  REQUIRE_FALSE(at_mains.ok());
  CHECK(at_mains.error().message.find("both exposures of the cycle are the same, 10 ms") == 0);
  const Exposure one[] = {{4ms, 1}}, two_of_three[] = {{1ms, 1}, {1ms, 1}, {4ms, 1}};
  CHECK(ExposureSchedule::create(one, sensor(), k30Hz).ok());
  CHECK(ExposureSchedule::create(two_of_three, sensor(), k30Hz).ok());
}

TEST_CASE("a coarse exposure unit is not mistaken for a line", "[capture]") {
  CameraCapabilities webcam = sensor();
  webcam.exposure_step = 100us;
  CHECK(ExposureSchedule::frame_margin(webcam) == 1ms);
}

TEST_CASE("a time becomes the nearest of whole half periods, as many as fit, and never none", "[capture]") {
  constexpr Duration kHalf = 10ms;
  CHECK(whole_half_periods(14ms, kHalf, 33ms) == 10ms);
  CHECK(whole_half_periods(16ms, kHalf, 33ms) == 20ms);
  CHECK(whole_half_periods(1s, kHalf, 33ms) == 30ms);
  CHECK(whole_half_periods(1ms, kHalf, 33ms) == kHalf);
  CHECK(whole_half_periods(1ms, kHalf, 4ms) == kHalf);
}

TEST_CASE("under mains light exposures become whole half periods, and short ones are flagged", "[capture]") {
  constexpr Exposure kIndoor[] = {{2ms, 1}, {9900us, 1}, {16ms, 1}, {26ms, 1}};
  const auto schedule = ExposureSchedule::create(kIndoor, sensor(), k30Hz, Mains::Hz50);
  REQUIRE(schedule.ok());
  const auto time = [&](int slot) { return schedule.value().slot(slot).exposure.time; };
  const auto flickers = [&](int slot) { return schedule.value().slot(slot).flickers; };
  CHECK((time(0) == 2ms && flickers(0)));
  CHECK((time(1) == 9900us && flickers(1)));
  CHECK((time(2) == 20ms && !flickers(2)));
  CHECK((time(3) == 30ms && !flickers(3)));

  // At 60 Hz, and never longer than the frame.
  const auto sixty = ExposureSchedule::create(kIndoor, sensor(), Duration(27'000'000), Mains::Hz60);
  REQUIRE(sixty.ok());
  CHECK(sixty.value().slot(1).exposure.time == 8330us);
  CHECK(sixty.value().slot(3).exposure.time == 25000us);

  // Half a period as the sensor's lines make it.
  constexpr Exposure kRounded[] = {{1ms, 1}, {8330us, 1}};
  const auto again = ExposureSchedule::create(kRounded, sensor(), k30Hz, Mains::Hz60);
  REQUIRE(again.ok());
  CHECK(again.value().slot(1).exposure.time == 8330us);
  CHECK_FALSE(again.value().slot(1).flickers);
}

}  // namespace
}  // namespace hdrcam
