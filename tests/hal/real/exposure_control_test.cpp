// The controls of a sensor whose driver is the test's.
#include "hal/real/exposure_control.h"

#include <linux/v4l2-controls.h>
#include <linux/v4l2-subdev.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <set>

#include "tests/contracts/expect.h"
#include "tests/support/answered_ioctl.h"

namespace hdrcam {
namespace {

constexpr int kWidth = 640, kHeight = 480;

// Like most drivers of sensors: the blanking limits the exposure, a value beyond its limit becomes the limit,
// and one between two steps the nearer one.
struct SensorDriver {
  std::map<std::uint32_t, std::int64_t> values{{V4L2_CID_EXPOSURE, 1200},
                                               {V4L2_CID_ANALOGUE_GAIN, 20},
                                               {V4L2_CID_VBLANK, 1000},
                                               {V4L2_CID_HBLANK, 160},
                                               {V4L2_CID_PIXEL_RATE, 24'000'000}};
  std::set<std::uint32_t> fixed{V4L2_CID_HBLANK, V4L2_CID_PIXEL_RATE};  // that can only be read
  std::int64_t least_gain = 1;                                          // code
  std::int64_t blanking_step = 1, exposure_step = 1;                    // lines

  std::int64_t step(std::uint32_t id) const {
    if (id == V4L2_CID_EXPOSURE) return exposure_step;
    return id == V4L2_CID_VBLANK ? blanking_step : 1;
  }
  std::int64_t most(std::uint32_t id) const {
    if (id == V4L2_CID_ANALOGUE_GAIN) return 232;
    return id == V4L2_CID_EXPOSURE ? kHeight + values.at(V4L2_CID_VBLANK) - 4 : 100'000'000;
  }
  void set(std::uint32_t id, std::int64_t value) {
    constexpr std::int64_t kLeast = 1;
    const std::int64_t steps = (std::min(value, most(id)) - kLeast + step(id) / 2) / step(id);
    values[id] = kLeast + steps * step(id);
    values[V4L2_CID_EXPOSURE] = std::min(values[V4L2_CID_EXPOSURE], most(V4L2_CID_EXPOSURE));
  }
  int operator()(unsigned long request, void* argument) {
    if (request == VIDIOC_QUERY_EXT_CTRL) {
      auto& asked = *static_cast<v4l2_query_ext_ctrl*>(argument);
      if (!values.contains(asked.id)) return EINVAL;
      asked.minimum = asked.id == V4L2_CID_ANALOGUE_GAIN ? least_gain : 1;
      asked.maximum = most(asked.id), asked.step = static_cast<std::uint64_t>(step(asked.id));
      if (asked.id == V4L2_CID_EXPOSURE_AUTO) std::strcpy(asked.name, "Exposure, Auto");
      asked.flags = fixed.contains(asked.id) ? V4L2_CTRL_FLAG_READ_ONLY : 0;
      return 0;
    }
    if (request == VIDIOC_SUBDEV_G_FMT)
      return static_cast<v4l2_subdev_format*>(argument)->format.width = kWidth, 0;
    if (request == VIDIOC_S_CTRL) {
      const auto& control = *static_cast<v4l2_control*>(argument);
      if (fixed.contains(control.id)) return EACCES;
      return values.contains(control.id) ? set(control.id, control.value), 0 : EINVAL;
    }
    if (request != VIDIOC_G_EXT_CTRLS && request != VIDIOC_S_EXT_CTRLS) return ENOTTY;
    const auto& controls = *static_cast<v4l2_ext_controls*>(argument);
    for (std::uint32_t i = 0; i < controls.count; ++i) {
      v4l2_ext_control& control = controls.controls[i];
      if (!values.contains(control.id)) return EINVAL;
      if (request == VIDIOC_S_EXT_CTRLS)
        set(control.id, control.value);
      else if (control.id == V4L2_CID_PIXEL_RATE)
        control.value64 = values[control.id];
      else
        control.value = static_cast<std::int32_t>(values[control.id]);
    }
    return 0;
  }
};

// What an IMX219 with such a driver can do.
CameraCapabilities described_sensor() {
  SensorDriver driver;
  const test::AnsweredIoctl kernel(
      [&](unsigned long request, void* argument) { return driver(request, argument); });
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  CameraCapabilities camera;
  ExposureControl::of_sensor(sensor, "imx219 10-0010").describe(camera);
  return camera;
}

TEST_CASE("a sensor does what it is asked for, and gets back the exposure, the gain and the frame duration") {
  SensorDriver driver;
  const auto before = driver.values;
  const test::AnsweredIoctl kernel(
      [&](unsigned long request, void* argument) { return driver(request, argument); });
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  ExposureControl control = ExposureControl::of_sensor(sensor, "imx219 10-0010");
  for (const Duration frame : {std::chrono::milliseconds(20), std::chrono::milliseconds(30)}) {
    require_done(control.take_over());
    const auto fixed = value_of(control.fix_frame_duration(kWidth, kHeight, frame));
    REQUIRE(fixed.has_value());
    CHECK(std::abs((*fixed - frame).count()) < 40'000);
    require_done(control.write({.exposure = std::chrono::milliseconds(5), .analogue_gain = 2}));
    // in lines of 33.3 us; the gain of a code is 256 / (256 - code)
    CHECK(driver.values[V4L2_CID_VBLANK] == 30 * frame / std::chrono::milliseconds(1) - kHeight);
    CHECK(driver.values[V4L2_CID_EXPOSURE] == 150);
    CHECK(driver.values[V4L2_CID_ANALOGUE_GAIN] == 128);
  }
  control.give_back();
  CHECK(driver.values == before);
}

TEST_CASE("a camera whose transfers fail once each loses no control, and gets all back as they were") {
  SensorDriver driver;
  driver.values[V4L2_CID_EXPOSURE_AUTO] = V4L2_EXPOSURE_APERTURE_PRIORITY;
  const auto before = driver.values;
  int calls = 0;
  const test::AnsweredIoctl kernel([&](unsigned long request, void* argument) {
    const bool transfers = request == VIDIOC_S_CTRL || request == VIDIOC_S_EXT_CTRLS ||
                           request == VIDIOC_G_EXT_CTRLS || request == VIDIOC_QUERY_EXT_CTRL;
    return transfers && ++calls % 2 == 1 ? EPIPE : driver(request, argument);
  });
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  ExposureControl control = ExposureControl::of_sensor(sensor, "imx219 10-0010");
  require_done(control.take_over());
  REQUIRE(value_of(control.fix_frame_duration(kWidth, kHeight, std::chrono::milliseconds(20))).has_value());
  require_done(control.write({.exposure = std::chrono::milliseconds(5), .analogue_gain = 2}));
  CHECK(driver.values[V4L2_CID_EXPOSURE_AUTO] == V4L2_EXPOSURE_MANUAL);
  CHECK(driver.values[V4L2_CID_EXPOSURE] == 150);  // lines of 33.3 us
  control.give_back();
  CHECK(driver.values == before);
}

TEST_CASE("a camera that does not answer any more holds the end of a run up by one time-out") {
  SensorDriver driver;
  bool hangs = false;
  int timed_out = 0;
  const test::AnsweredIoctl kernel([&](unsigned long request, void* argument) {
    return hangs ? (++timed_out, ETIMEDOUT) : driver(request, argument);
  });
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  ExposureControl control = ExposureControl::of_sensor(sensor, "imx219 10-0010");
  require_done(control.take_over());
  hangs = true;
  control.give_back();
  CHECK(timed_out == 1);
}

TEST_CASE(
    "the frame duration of a sensor whose blanking has steps is that of the step that its driver took") {
  SensorDriver driver;
  driver.blanking_step = 64;
  const test::AnsweredIoctl kernel(
      [&](unsigned long request, void* argument) { return driver(request, argument); });
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  ExposureControl control = ExposureControl::of_sensor(sensor, "imx219 10-0010");
  const auto fixed = value_of(control.fix_frame_duration(kWidth, kHeight, std::chrono::milliseconds(20)));
  REQUIRE(fixed.has_value());
  CHECK(driver.values[V4L2_CID_VBLANK] == 129);  // 1 + 2 * 64, the nearest to 600 - 480 lines
  CHECK(std::abs((*fixed - std::chrono::microseconds(20'300)).count()) < 1000);
}

TEST_CASE("a camera that keeps one of its automatic controls is told which") {
  const std::pair<std::uint32_t, const char*> kAutomatic[] = {
      {V4L2_CID_EXPOSURE_AUTO, "automatic exposure"},
      {V4L2_CID_EXPOSURE_AUTO_PRIORITY, "frame rate"},
      {V4L2_CID_AUTOGAIN, "automatic gain"},
      {V4L2_CID_AUTO_WHITE_BALANCE, "automatic white balance"}};
  for (const auto& [kept, word] : kAutomatic) {
    SensorDriver driver;
    for (const auto& [id, unused] : kAutomatic) driver.values[id] = 1;
    const test::AnsweredIoctl kernel([&, refused = kept](unsigned long request, void* argument) {
      const bool sets = request == VIDIOC_S_CTRL;
      return sets && static_cast<v4l2_control*>(argument)->id == refused ? EIO : driver(request, argument);
    });
    const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
    const Result<void> taken = ExposureControl::of_sensor(sensor, "imx219 10-0010").take_over();
    require_error(taken, ErrorCode::Io);
    CHECK(taken.error().message.find(word) != std::string::npos);
  }
}

TEST_CASE("a control that a camera refuses is named, with the value, the device, the reason and what to do") {
  for (const int code : {EIO, EACCES, EPIPE}) {
    SensorDriver driver;
    driver.values[V4L2_CID_EXPOSURE_AUTO] = V4L2_EXPOSURE_APERTURE_PRIORITY;
    const test::AnsweredIoctl kernel([&](unsigned long request, void* argument) {
      return request == VIDIOC_S_CTRL ? code : driver(request, argument);
    });
    const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
    const Result<void> taken = ExposureControl::of_sensor(sensor, "imx219 10-0010").take_over();
    require_error(taken, ErrorCode::Io);
    CHECK(taken.error().sys_errno == code);
    CHECK(taken.error().message ==
          fmt::format(
              "'/dev/null' refused to switch its automatic exposure off (control 'Exposure, Auto' to "
              "1): {}; see with 'v4l2-ctl -d /dev/null -L' what the control takes, plug a USB camera in "
              "again, or choose another",
              std::strerror(code)));
  }
}

TEST_CASE("the limits of a sensor's exposure are times before it is configured, too") {
  const CameraCapabilities camera = described_sensor();
  // a line is 640 + 160 pixels at 24 MHz
  CHECK(camera.exposure_step.count() == 33'333'333);  // ps
  CHECK(camera.exposure_min == Duration(33'333));
  CHECK(camera.exposure_max == Duration(49'200'000));  // 480 + 1000 - 4 of them
}

TEST_CASE("the exposures of a sensor are steps that begin at its shortest, and each is set as it is told") {
  SensorDriver driver;
  driver.exposure_step = 16;
  const test::AnsweredIoctl kernel(
      [&](unsigned long request, void* argument) { return driver(request, argument); });
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  const ExposureControl control = ExposureControl::of_sensor(sensor, "imx219 10-0010");
  CameraCapabilities camera;
  control.describe(camera);
  CHECK(camera.exposure_min == Duration(33'333));      // a line
  CHECK(camera.exposure_max == Duration(49'100'000));  // 1 + 92 * 16 of them: 1476 are no whole steps
  CHECK(camera.exposure_step.count() == 533'333'333);  // ps
  for (const int steps : {0, 1, 30, 92}) {
    const auto above = std::chrono::round<Duration>(steps * camera.exposure_step);
    require_done(control.write({.exposure = camera.exposure_min + above}));
    CHECK(driver.values[V4L2_CID_EXPOSURE] == 1 + 16 * steps);
  }
}

TEST_CASE("the gains of a sensor are those of its codes, whose steps grow with the gain") {
  const CameraCapabilities camera = described_sensor();
  REQUIRE(camera.gains.size() == 232);
  CHECK(camera.gain_step == 0);
  CHECK(camera.gains.front() == camera.gain_min);
  CHECK(camera.gains.back() == camera.gain_max);
  CHECK(camera.gains[229] == Approx(256. / 26));
  CHECK(camera.gains[230] == Approx(256. / 25));
}

TEST_CASE("the gain of an unlisted sensor whose codes begin at 0 is left alone, for they define no factors") {
  for (const auto& [name, is_set] : {std::pair{"some sensor", false}, {"imx219 10-0010", true}}) {
    SensorDriver driver;
    driver.least_gain = 0;
    const test::AnsweredIoctl kernel(
        [&](unsigned long request, void* argument) { return driver(request, argument); });
    const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
    const ExposureControl control = ExposureControl::of_sensor(sensor, name);
    CameraCapabilities camera;
    control.describe(camera);
    INFO(name);
    CHECK(camera.gain_min == 1);
    CHECK((camera.gain_max > 1) == is_set);
    require_done(control.write({.exposure = std::chrono::milliseconds(5), .analogue_gain = 2}));
    CHECK((driver.values[V4L2_CID_ANALOGUE_GAIN] != SensorDriver().values[V4L2_CID_ANALOGUE_GAIN]) == is_set);
  }
}

TEST_CASE("controls that a driver lets nobody set stay as they are, and the frame duration is what it is") {
  SensorDriver driver;
  driver.values[V4L2_CID_AUTO_WHITE_BALANCE] = 1;
  driver.fixed.insert({V4L2_CID_VBLANK, V4L2_CID_AUTO_WHITE_BALANCE, V4L2_CID_ANALOGUE_GAIN});
  const auto before = driver.values;
  const test::AnsweredIoctl kernel(
      [&](unsigned long request, void* argument) { return driver(request, argument); });
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  ExposureControl control = ExposureControl::of_sensor(sensor, "imx415 10-001a");
  require_done(control.take_over());
  const auto fixed = value_of(control.fix_frame_duration(kWidth, kHeight, std::chrono::milliseconds(20)));
  REQUIRE(fixed.has_value());
  // 480 + 1000 lines of 33.3 us
  CHECK(std::abs((*fixed - std::chrono::microseconds(49'333)).count()) < 1000);
  CameraCapabilities camera;
  control.describe(camera);
  CHECK(camera.sets_exposure);
  CHECK(camera.gain_max == 1);
  require_done(control.write({.exposure = std::chrono::milliseconds(5)}));
  CHECK(driver.values != before);
  control.give_back();
  CHECK(driver.values == before);
}

TEST_CASE(
    "a sensor that is known to roll is read out line by line, as its driver states; another in no time") {
  SensorDriver driver;
  const test::AnsweredIoctl kernel(
      [&](unsigned long request, void* argument) { return driver(request, argument); });
  const DeviceNode sensor = value_of(DeviceNode::open("/dev/null"));
  const auto readout_of = [&](const char* name) {
    ExposureControl control = ExposureControl::of_sensor(sensor, name);
    REQUIRE(value_of(control.fix_frame_duration(kWidth, kHeight, std::chrono::milliseconds(33))).has_value());
    return control.readout(kHeight);
  };
  // 480 lines of 640 + 160 pixels at 24 MHz
  CHECK(std::abs((readout_of("imx219 10-0010") - std::chrono::milliseconds(16)).count()) < 1000);
  CHECK(readout_of("ov9281 1-0060") == Duration::zero());
  CHECK(readout_of("some sensor") == Duration::zero());
  CHECK(ExposureControl::of_video_node(sensor).readout(kHeight) == Duration::zero());  // a USB camera
}

}  // namespace
}  // namespace hdrcam
