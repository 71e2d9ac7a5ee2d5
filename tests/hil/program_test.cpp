// The program itself, on a camera that says the truth in each picture: calibrate its delay, record, run live,
// have the plug pulled.
#include <fmt/format.h>
#include <thread>
#include <vector>

#include "tests/contracts/expect.h"
#include "tests/hil/bed.h"
#include "tests/hil/label_tally.h"
#include "tests/hil/program.h"

namespace hdrcam::hil {
namespace {

// Each test replaces the files of the one before it: --force.
using namespace std::chrono_literals;

constexpr int kRate_hz = 15;
constexpr int kFrames = 120;

void succeeds(const std::vector<std::string>& arguments) {
  const int code = Program(arguments).exit_code();
  INFO(Program::words());
  REQUIRE(code == 0);
}

const std::vector<std::string> kMode{"--format", "YUYV", "--width",     "160",
                                     "--height", "120",  "--framerate", std::to_string(kRate_hz)};
constexpr const char *kConfig = "/tmp/camera.toml", *kRecording = "/tmp/program.mkv";

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

void calibrate(const std::string& camera) {
  succeeds(std::vector<std::string>{"calibrate", "delay", "--camera", camera, "-o", kConfig, "--force"} +
           kMode);
}

// One emulated processor captures, fits and encodes: a control may be late before the pictures can prove it.
void check_labels(const std::string& what) {
  constexpr int kProofs = 8;  // frames that a proof looks at
  const LabelTally tally = labels_of_recording(kRecording, kProofs);
  fmt::print("{}: {}\n", what, tally.text());
  INFO(Program::words());
  CHECK(tally.frames == kFrames);
  CHECK(tally.wrong == 0);
  CHECK(tally.flagged == 0);
}

const std::vector<std::string> kLive{"live",     "--config", kConfig,
                                     "--preset", "fast",     "--record",
                                     kRecording, "--frames", std::to_string(kFrames),
                                     "--force"};

void live_labels_are_true(int latency) {
  const UsbCamera plugged(latency, kRate_hz);
  calibrate("libcamera:" + plugged.name());
  succeeds(kLive);
  check_labels(fmt::format("hdrcam live, libcamera, latency {}", latency));
}

TEST_CASE("hdrcam live through libcamera gives every frame its true exposure: latency 0") {
  live_labels_are_true(0);
}
TEST_CASE("hdrcam live through libcamera gives every frame its true exposure: latency 1") {
  live_labels_are_true(1);
}
TEST_CASE("hdrcam live through libcamera gives every frame its true exposure: latency 2") {
  live_labels_are_true(2);
}
TEST_CASE("hdrcam live through libcamera gives every frame its true exposure: latency 3") {
  live_labels_are_true(3);
}

TEST_CASE("hdrcam live through V4L2 gives every frame its true exposure") {
  const UsbCamera plugged(2, kRate_hz);
  calibrate(plugged.node());
  succeeds(kLive);
  check_labels("hdrcam live, V4L2, latency 2");
}

TEST_CASE("hdrcam record through V4L2 gives every frame its true exposure") {
  const UsbCamera plugged(1, kRate_hz);
  calibrate(plugged.node());
  succeeds({"record", "--config", kConfig, "-o", kRecording, "--frames", std::to_string(kFrames), "--force"});
  check_labels("hdrcam record, V4L2, latency 1");
}

TEST_CASE("a camera that is unplugged ends hdrcam record with its exit code, and the recording is whole") {
  constexpr int kUnplugged = 14;
  UsbCamera plugged(1, kRate_hz);
  Program record(std::vector<std::string>{"record", "--camera", plugged.node(), "--control-delay", "1", "-o",
                                          kRecording, "--force"} +
                 kMode);
  std::this_thread::sleep_for(10s);
  plugged.unplug();
  const int code = record.exit_code();
  INFO(Program::words());
  CHECK(code == kUnplugged);
  const LabelTally tally = labels_of_recording(kRecording);
  fmt::print("hdrcam record, unplugged, exit {}: {}\n", code, tally.text());
  CHECK(tally.frames >= 10);
  CHECK(tally.wrong == 0);
  CHECK(tally.flagged == 0);
}

}  // namespace
}  // namespace hdrcam::hil
