#include "firmware_host/run/deadline.h"

#include <chrono>

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

TEST_CASE("a camera's deadline is its frame interval, a recording has none, and the setting overrules both") {
  CameraFacts camera;
  camera.framerate_hz = 25;
  Settings::Fit fit;
  CHECK(deadline_of(fit, camera, RunPace::Camera) == Duration(milliseconds(40)));
  CHECK_FALSE(deadline_of(fit, camera, RunPace::Clip));
  fit.deadline = "12.5ms";
  CHECK(deadline_of(fit, camera, RunPace::Camera) == Duration(microseconds(12500)));
  CHECK(deadline_of(fit, camera, RunPace::Clip) == Duration(microseconds(12500)));
  fit.deadline = "off";
  CHECK_FALSE(deadline_of(fit, camera, RunPace::Camera));
  fit.deadline = "";
  camera.framerate_hz = 0;
  CHECK_FALSE(deadline_of(fit, camera, RunPace::Camera));
}

TEST_CASE("to hold the frame interval is to keep up with the camera, to hold less is not") {
  CameraFacts camera;
  for (const double framerate_hz : {24.0, 25.0, 30000 / 1001.0, 30.0, 59.94}) {
    camera.framerate_hz = framerate_hz;
    const auto interval = deadline_of(Settings::Fit{}, camera, RunPace::Camera);
    REQUIRE(interval);
    CHECK(is_pace_of(camera, *interval));
    CHECK(is_pace_of(camera, 2 * *interval));
    CHECK_FALSE(is_pace_of(camera, *interval * 9 / 10));
  }
}

}  // namespace
}  // namespace hdrcam
