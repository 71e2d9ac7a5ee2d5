// The statement that all else rests upon: the exposure with which the capture side labels a frame is the one
// that the frame has. The simulated USB camera writes the truth into each picture; between it and the label
// lie the kernel's uvcvideo driver, V4L2 or libcamera, and the whole of capture/.
#include <string>
#include <thread>

#include "capture/capture_stage.h"
#include "capture/delay_calibration.h"
#include "hal/real/camera_libcamera.h"
#include "hal/real/camera_v4l2.h"
#include "hal/real/sync_line_gpiod.h"
#include "hal/recording/recording.h"
#include "tests/contracts/expect.h"
#include "tests/hil/bed.h"
#include "tests/hil/label_tally.h"
#include "tests/hil/usb_camera/picture_stamp.h"

namespace hdrcam::hil {
namespace {

using namespace std::chrono_literals;

constexpr StreamMode kMode{PixelFormat::Yuyv, 320, 240, Duration(66'666'600)};
constexpr StreamMode kSlowMode{PixelFormat::Yuyv, 320, 240, Duration(200'000'000)};
constexpr int kRate_hz = 15, kBuffers = 8, kFrames = 120;
constexpr Exposure kCycle[] = {{1ms, 1}, {4ms, 1}, {16ms, 1}};

using Open = std::unique_ptr<Camera> (*)(const UsbCamera&);
std::unique_ptr<Camera> through_v4l2(const UsbCamera& plugged) {
  return value_of(open_v4l2_camera(plugged.node()));
}
std::unique_ptr<Camera> through_libcamera(const UsbCamera& plugged) {
  return value_of(open_libcamera_camera(plugged.name()));
}

// A frame later than the first cycle is flagged only with a reason: on a busy machine controls are written
// late.
void check_flags(const LabelTally& tally, const CaptureCounters& counters) {
  CHECK(tally.flagged <= static_cast<int>(counters.controls_late));
}

void print(const std::string& what, const LabelTally& tally, const CaptureCounters& c) {
  fmt::print("{}: {}; {} proved, {} relabelled, {} controls late, {} lost, {} relocks\n", what, tally.text(),
             c.proved, c.relabelled, c.controls_late, c.lost_by_camera, c.relocks);
}

ControlDelays measured_delays(Camera& camera) {
  const StreamMode mode = value_of(camera.configure(kMode, kBuffers));
  const std::atomic<bool> stop{false};
  const auto measure = [&](const Exposure& shorter, const Exposure& longer) {
    const DelayEstimate estimate = value_of(measure_delay(
        camera, {.shorter = shorter, .longer = longer, .mode = mode, .buffers = kBuffers, .frames = 80},
        stop));
    INFO(estimate.reason);
    REQUIRE(estimate.delay.has_value());
    return *estimate.delay;
  };
  const int exposure = measure({2ms, 1}, {8ms, 1});
  return {exposure, camera.capabilities().gain_max > 1 ? measure({2ms, 1}, {2ms, 4}) : exposure};
}

std::unique_ptr<CaptureStage> started(Camera& camera, SyncLine* strobe, CaptureOptions options) {
  if (options.mode.width == 0) options.mode = kMode;
  options.buffers = kBuffers;
  auto stage = value_of(CaptureStage::open(camera, strobe, kCycle, Mains::Off, options));
  require_done(stage->start());
  return stage;
}

void labels_are_true(const char* driver, Open open, int latency) {
  const UsbCamera plugged(latency, kRate_hz);
  const auto camera = open(plugged);
  const ControlDelays delays = measured_delays(*camera);
  CHECK(delays == ControlDelays{latency, latency});
  const auto stage = started(*camera, nullptr, {.delays = delays});
  CapturedFrame frame;
  LabelTally tally;
  for (int i = 0; i < kFrames; ++i) {
    require_done(stage->next(frame));
    tally.add(frame.raw);
  }
  print(fmt::format("{}, latency {}", driver, latency), tally, stage->counters());
  CHECK(tally.wrong == 0);
  check_flags(tally, stage->counters());
}

TEST_CASE("V4L2: every label is the exposure in the picture: latency 0") {
  labels_are_true("V4L2", through_v4l2, 0);
}
TEST_CASE("V4L2: every label is the exposure in the picture: latency 1") {
  labels_are_true("V4L2", through_v4l2, 1);
}
TEST_CASE("V4L2: every label is the exposure in the picture: latency 2") {
  labels_are_true("V4L2", through_v4l2, 2);
}
TEST_CASE("V4L2: every label is the exposure in the picture: latency 3") {
  labels_are_true("V4L2", through_v4l2, 3);
}
TEST_CASE("libcamera: every label is the exposure in the picture: latency 0") {
  labels_are_true("libcamera", through_libcamera, 0);
}
TEST_CASE("libcamera: every label is the exposure in the picture: latency 1") {
  labels_are_true("libcamera", through_libcamera, 1);
}
TEST_CASE("libcamera: every label is the exposure in the picture: latency 2") {
  labels_are_true("libcamera", through_libcamera, 2);
}
TEST_CASE("libcamera: every label is the exposure in the picture: latency 3") {
  labels_are_true("libcamera", through_libcamera, 3);
}

// Controls are written late then, and act on later frames than they should.
void survives_stalls(const char* driver, Open open, int latency) {
  const UsbCamera plugged(latency, kRate_hz);
  const auto camera = open(plugged);
  const auto stage = started(*camera, nullptr, {.delays = ControlDelays{latency, latency}});
  CapturedFrame frame;
  LabelTally tally;
  for (int i = 0; i < kFrames; ++i) {
    if (i % 15 == 14) std::this_thread::sleep_for(i % 2 == 0 ? 100ms : 250ms);
    require_done(stage->next(frame));
    tally.add(frame.raw);
  }
  print(fmt::format("{}, latency {}, stalls", driver, latency), tally, stage->counters());
  CHECK(tally.wrong == 0);
  CHECK(tally.equal > kFrames / 2);
  CHECK(stage->counters().controls_late > 0);
}

TEST_CASE("V4L2: no label is wrong when the machine stalls") {
  for (const int latency : {0, 2}) survives_stalls("V4L2", through_v4l2, latency);
}
TEST_CASE("libcamera: no label is wrong when the machine stalls") {
  for (const int latency : {0, 2}) survives_stalls("libcamera", through_libcamera, latency);
}

void survives_losses(const char* driver, Open open, int latency) {
  constexpr int kLoseEvery = 20;
  const UsbCamera plugged(latency, kRate_hz, "", kLoseEvery);
  const auto camera = open(plugged);
  const auto stage = started(*camera, nullptr, {.delays = ControlDelays{latency, latency}});
  CapturedFrame frame;
  LabelTally tally;
  std::uint32_t before = 0;
  int missing = 0, unseen = 0;
  for (int i = 0; i < kFrames; ++i) {
    require_done(stage->next(frame));
    const std::uint32_t shown = read_stamp(frame.raw.codes)->frame;
    const int really = i == 0 ? 0 : static_cast<int>(shown - before) - 1;
    before = shown, missing += really;
    unseen += really != frame.lost_before ? 1 : 0;
    CHECK((frame.lost_before > 0) == ((frame.raw.facts.flags & kFrameAfterDrop) != 0));
    tally.add(frame.raw);
  }
  print(fmt::format("{}, latency {}, {} frames lost, {} counts wrong", driver, latency, missing, unseen),
        tally, stage->counters());
  CHECK(missing >= kFrames / kLoseEvery - 1);
  CHECK(tally.wrong == 0);
  check_flags(tally, stage->counters());  // found again within one cycle
  CHECK(unseen == 0);
}

TEST_CASE("V4L2: lost frames are counted, and make no label wrong") {
  for (const int latency : {0, 2}) survives_losses("V4L2", through_v4l2, latency);
}
TEST_CASE("libcamera: lost frames are counted, and make no label wrong") {
  survives_losses("libcamera", through_libcamera, 1);
}

TEST_CASE("strobe pulses are found for their frames, and count those that are lost") {
  const SimulatedPin pin(1);
  pin.drive(false);
  const auto strobe = value_of(open_gpio_line({.line = "STROBE"}));
  const UsbCamera plugged(1, kRate_hz, pin.pull_file(), 20);
  const auto camera = through_v4l2(plugged);
  const auto stage =
      started(*camera, strobe.get(), {.delays = ControlDelays{1, 1}, .strobe = StrobePulse::MarksFrame});
  CapturedFrame frame;
  LabelTally tally;
  for (int i = 0; i < 60; ++i) {
    require_done(stage->next(frame));
    tally.add(frame.raw);
  }
  print(fmt::format("strobe: {} of 60 frames have a pulse", stage->counters().strobed), tally,
        stage->counters());
  CHECK(tally.wrong == 0);
  check_flags(tally, stage->counters());
  CHECK(tally.losses >= 2);
  CHECK(stage->counters().strobed >= 57);
}

void records_until_unplugged(const char* driver, Open open) {
  constexpr int kUntil = 25, kSlowRate_hz = 5;  // one emulated processor captures and encodes
  const std::string path = std::string("/tmp/") + driver + ".mkv";
  UsbCamera plugged(1, kSlowRate_hz);
  const auto camera = open(plugged);
  const auto stage = started(*camera, nullptr, {.mode = kSlowMode, .delays = ControlDelays{1, 1}});
  const auto recording = value_of(create_recording(posix_storage(), path, stage->facts()));
  CapturedFrame frame;
  int recorded = 0;
  Result<void> end;
  for (;; ++recorded) {
    if (recorded == kUntil) plugged.unplug();
    end = stage->next(frame);
    if (!end) break;
    require_done(recording->append(frame.raw));
  }
  require_error(end, ErrorCode::Unplugged);
  require_done(stage->stop());
  require_done(recording->finish());
  const LabelTally tally = labels_of_recording(path);
  print(fmt::format("{}, unplugged after {}, {} recorded", driver, kUntil, recorded), tally,
        stage->counters());
  CHECK(tally.frames == recorded);
  CHECK(recorded >= kUntil);
  CHECK(tally.wrong == 0);
  check_flags(tally, stage->counters());
}

TEST_CASE("V4L2: what was recorded before the plug is pulled is whole and labelled right") {
  records_until_unplugged("V4L2", through_v4l2);
}
TEST_CASE("libcamera: what was recorded before the plug is pulled is whole and labelled right") {
  records_until_unplugged("libcamera", through_libcamera);
}

}  // namespace
}  // namespace hdrcam::hil
