#include "capture/exposure.h"

#include <chrono>
#include <cmath>
#include <cstdint>
#include <vector>

#include <fmt/format.h>
#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

CameraCapabilities sensor() {
  CameraCapabilities camera;
  camera.id = "imx219";
  camera.exposure_min = 20us, camera.exposure_max = 30ms, camera.exposure_step = 20us;
  camera.gain_min = 1, camera.gain_max = 10, camera.gain_step = 0.25;
  return camera;
}

Duration nearest_time(Duration asked, const CameraCapabilities& camera) {
  return quantised({asked, 1}, camera).value().time;
}

TEST_CASE("a cycle is described by its exposures, one after the other", "[capture]") {
  const std::vector<Exposure> cycle{{1ms, 1}, {4ms, 2}, {250us, 1}};
  CHECK(describe(cycle) == "1 ms, 4 ms x 2, 250 us");
  CHECK(describe(std::vector<Exposure>()).empty());
}

TEST_CASE("durations are read as photographers write them", "[capture]") {
  CHECK(parse_duration("4ms").value() == 4ms);
  CHECK(parse_duration(" 250us ").value() == 250us);
  CHECK(parse_duration("1/250").value() == 4ms);
  CHECK(parse_duration("1/250s").value() == 4ms);
  CHECK(parse_duration("0.004 s").value() == 4ms);
  CHECK(parse_duration("1.5ms").value() == 1500us);
  for (const char* wrong :
       {"", "ms", "-4ms", "0ms", "1/0", "4 parsecs", "nan", "inf", "4ms5", "1e9s", "1/-250"}) {
    CAPTURE(wrong);
    const auto duration = parse_duration(wrong);
    REQUIRE_FALSE(duration.ok());
    CHECK(duration.error().code == ErrorCode::Invalid);
    CHECK(duration.error().message.find("write it like") != std::string::npos);
  }
  for (const char* number : {"33", " 0.004"}) {
    const auto duration = parse_duration(number);
    REQUIRE_FALSE(duration.ok());
    CHECK(duration.error().message.find("has no unit; write ") != std::string::npos);
  }
  CHECK(parse_duration("33").error().message == "the time '33' has no unit; write 33ms or 33s");
}

TEST_CASE("a duration that is too short or too long is told with the limits", "[capture]") {
  CHECK(parse_duration("3600s").value() == 1h);
  CHECK(parse_duration("0.001us").value() == 1ns);
  for (const char* outside : {"4000s", "0.0001us", "0ms", "-4ms", "1/-250"}) {
    CAPTURE(outside);
    CHECK(
        parse_duration(outside).error().message ==
        fmt::format("'{}' is outside 0.001us to 3600s; write it like 4ms, 250us, 1/250 or 0.004s", outside));
  }
}

TEST_CASE("an error in one of a cycle's times quotes the cycle, too", "[capture]") {
  CHECK(parse_exposures("1ms,,4ms", "").error().message ==
        "shutter times '1ms,,4ms': '' is not a duration; write it like 4ms, 250us, 1/250 or 0.004s");
}

TEST_CASE("a time before or after another one has a sign, or is 0", "[capture]") {
  CHECK(parse_signed_duration("250us").value() == 250us);
  CHECK(parse_signed_duration(" -2ms").value() == -2ms);
  CHECK(parse_signed_duration("-1/500").value() == -2ms);
  for (const char* zero : {"0", "0ms", "0us", "-0s"}) CHECK(parse_signed_duration(zero).value() == 0ms);
  for (const char* wrong : {"", "ms", "--2ms", "2 parsecs", "nan", "1e9s", "-1e9s", "-2ms5"}) {
    CAPTURE(wrong);
    const auto time = parse_signed_duration(wrong);
    REQUIRE_FALSE(time.ok());
    CHECK(time.error().code == ErrorCode::Invalid);
    CHECK(time.error().message.find("write it like 250us, -2ms or 0") != std::string::npos);
  }
  CHECK(parse_signed_duration("-2").error().message == "the time '-2' has no unit; write -2ms or -2s");
}

TEST_CASE("a cycle is a list of shutter times and of gains", "[capture]") {
  const auto cycle = parse_exposures("1ms,4ms,16ms", "1, 1, 2");
  REQUIRE(cycle.ok());
  CHECK(cycle.value() == std::vector<Exposure>{{1ms, 1}, {4ms, 1}, {16ms, 2}});
  CHECK(parse_exposures("1ms,4ms", "").value() == std::vector<Exposure>{{1ms, 1}, {4ms, 1}});
  CHECK(parse_exposures("1ms,4ms", "", 1.25).value() == std::vector<Exposure>{{1ms, 1.25}, {4ms, 1.25}});
  CHECK(parse_exposures("1ms,4ms", "2.5").value() == std::vector<Exposure>{{1ms, 2.5}, {4ms, 2.5}});
  CHECK(parse_exposures("20ms", "1,4").value() == std::vector<Exposure>{{20ms, 1}, {20ms, 4}});
  CHECK_FALSE(parse_exposures("1ms,4ms", "1,2,3").ok());
  CHECK_FALSE(parse_exposures("1ms,,4ms", "").ok());
  CHECK_FALSE(parse_exposures("1ms", "0").ok());
  CHECK_FALSE(parse_exposures("1ms", "two").ok());
}

TEST_CASE("a gain is one that a recording can hold", "[capture]") {
  CHECK(parse_exposures("1ms", "1e6").ok());
  CHECK(parse_exposures("1ms,4ms", "1,1e40").error().message ==
        "'1e40' is not a gain; write a number above 0, up to 1000000, like 1 or 2.5");
}

TEST_CASE("exposures are those that the sensor can do", "[capture]") {
  CHECK(quantised({4009us, 1.1}, sensor()).value() == Exposure{4000us, 1});
  CHECK(quantised({4011us, 1.13}, sensor()).value() == Exposure{4020us, 1.25});
  CHECK(quantised({11us, 1}, sensor()).value() == Exposure{20us, 1});
  for (const Exposure& wrong : {Exposure{9us, 1}, Exposure{31ms, 1}, Exposure{4ms, 0.5}, Exposure{4ms, 11}}) {
    const auto exposure = quantised(wrong, sensor());
    REQUIRE_FALSE(exposure.ok());
    CHECK(exposure.error().code == ErrorCode::BadExposure);
    CHECK(exposure.error().message.find("imx219") != std::string::npos);
  }
  CameraCapabilities continuous = sensor();
  continuous.exposure_step = Duration(1), continuous.gain_step = 0;
  CHECK(quantised({4009us, 1.13}, continuous).value() == Exposure{4009us, 1.13});
}

TEST_CASE("the exposures that a sensor can do are whole steps above its shortest", "[capture]") {
  CameraCapabilities camera = sensor();
  camera.exposure_min = 300us, camera.exposure_step = 500us;
  CHECK(quantised({1ms, 1}, camera).value().time == 800us);
  CHECK(quantised({1100us, 1}, camera).value().time == 1300us);
  CHECK(quantised({60us, 1}, camera).value().time == 300us);
  CHECK_FALSE(quantised({40us, 1}, camera).ok());
}

TEST_CASE("the longest exposure within a limit is a whole step above the sensor's shortest", "[capture]") {
  CameraCapabilities camera = sensor();
  camera.exposure_min = 300us, camera.exposure_step = 500us;
  CHECK(longest_within(10ms, camera) == 9800us);
  CHECK(longest_within(9800us, camera) == 9800us);
  CHECK(longest_within(9799us, camera) == 9300us);
  CHECK(longest_within(299us, camera) == 299us);  // which the sensor does not have
  camera.exposure_step = Duration(1);
  CHECK(longest_within(9'799'123ns, camera) == 9'799'123ns);
}

TEST_CASE("an exposure of many lines is a whole number of them, though a line is no whole nanosecond",
          "[capture]") {
  CameraCapabilities camera = sensor();
  constexpr double kLine_ns = 7407.4074;
  using Picoseconds = std::chrono::duration<std::int64_t, std::pico>;
  camera.exposure_min = from_seconds(4 * kLine_ns * 1e-9), camera.exposure_max = 2s;
  camera.exposure_step = Picoseconds(std::llround(kLine_ns * 1000));
  constexpr int kRounding_ns = 100;  // of the step's picoseconds, over all lines: a line is 7407 ns
  for (const int lines : {100, 14'999, 50'000, 200'000}) {
    const Duration whole = from_seconds(lines * kLine_ns * 1e-9);
    CAPTURE(lines, whole.count());
    for (const Duration asked : {whole - 3us, whole, whole + 3us})
      CHECK(std::abs((nearest_time(asked, camera) - whole).count()) <= kRounding_ns);
    CHECK(std::abs((longest_within(whole + 1us, camera) - whole).count()) <= kRounding_ns);
    const Duration own = nearest_time(whole, camera);
    CHECK(longest_within(own, camera) == own);
  }
}

TEST_CASE("a gain whose steps grow with it becomes the nearest one that the sensor has", "[capture]") {
  CameraCapabilities camera = sensor();
  camera.gain_step = 0;
  for (int code = 0; code <= 232; ++code) camera.gains.push_back(256. / (256 - code));
  camera.gain_max = camera.gains.back();
  CHECK(quantised({4ms, 10}, camera).value().gain == Approx(256. / 26));  // 9.85, not 10; the next is 10.24
  CHECK(quantised({4ms, 10.1}, camera).value().gain == Approx(256. / 25));
  CHECK(quantised({4ms, 1.001}, camera).value().gain == 1);
  CHECK(quantised({4ms, 10.8}, camera).value().gain == Approx(256. / 24));
  CHECK_FALSE(quantised({4ms, 11}, camera).ok());
  CHECK_FALSE(quantised({4ms, .99}, camera).ok());
}

}  // namespace
}  // namespace hdrcam
