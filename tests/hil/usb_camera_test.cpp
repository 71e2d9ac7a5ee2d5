// A USB camera (simulated behind the kernel's own uvcvideo), through V4L2 and through libcamera. Whether its
// exposures are known is the matter of exposure_proof_test.cpp.
#include "hal/real/camera_libcamera.h"
#include "hal/real/camera_v4l2.h"
#include "hal/real/sync_line_gpiod.h"
#include "tests/contracts/camera_contract.h"
#include "tests/contracts/expect.h"
#include "tests/hil/bed.h"

namespace hdrcam::hil {
namespace {

using std::chrono::milliseconds;

constexpr StreamMode kMode{PixelFormat::Yuyv, 320, 240, Duration(33'333'300)};

constexpr std::chrono::seconds kPatience(5);

// For the tests that leave it plugged in.
const UsbCamera& standing_camera() {
  static const UsbCamera camera(1);
  return camera;
}

TEST_CASE("a USB camera keeps the camera contract") {
  keeps_camera_contract({.name = "usb",
                         .open = [] { return open_v4l2_camera(standing_camera().node()); },
                         .mode = kMode,
                         .frames = 20,
                         .drops_frames = true});
}

TEST_CASE("libcamera's USB camera keeps the camera contract") {
  keeps_camera_contract({.name = "usb, libcamera",
                         .open = [] { return open_libcamera_camera(standing_camera().name()); },
                         .mode = kMode,
                         .frames = 20,
                         .drops_frames = true,
                         .allocations_per_frame = 60});
}

void survives_unplugging(UsbCamera& plugged, std::unique_ptr<Camera> camera) {
  value_of(camera->configure(kMode, 4));
  require_done(camera->start());
  for (int i = 0; i < 4; ++i) require_done(camera->queue({.exposure = milliseconds(5)}));
  for (int i = 0; i < 3; ++i) {
    { const auto buffer = value_of(camera->wait(kPatience)); }
    require_done(camera->queue({.exposure = milliseconds(5)}));
  }
  plugged.unplug();
  Result<void> end;
  for (int i = 0; i < 20 && end.ok(); ++i) {
    if (const auto buffer = camera->wait(kPatience); !buffer.ok()) end = buffer.error();
  }
  require_error(end, ErrorCode::Unplugged);
  require_done(camera->stop());
  CHECK_FALSE(camera->start().ok());
}

TEST_CASE("a USB camera that is unplugged in mid-stream says so and stops") {
  UsbCamera plugged(1);
  survives_unplugging(plugged, value_of(open_v4l2_camera(plugged.node())));
}

TEST_CASE("libcamera's USB camera that is unplugged in mid-stream says so and stops") {
  UsbCamera plugged(1);
  survives_unplugging(plugged, value_of(open_libcamera_camera(plugged.name())));
}

TEST_CASE("a camera that libcamera streams from is busy for a second user") {
  const std::string name = standing_camera().name();
  auto first = value_of(open_libcamera_camera(name));
  require_error(open_libcamera_camera(name), ErrorCode::Busy);
}

TEST_CASE("strobe edges lie between the frames that they belong to") {
  const SimulatedPin pin(1);
  pin.drive(false);
  auto strobe = value_of(open_gpio_line({.line = "STROBE"}));
  const UsbCamera plugged(1, 15, pin.pull_file());
  auto camera = value_of(open_v4l2_camera(plugged.node()));
  value_of(camera->configure(kMode, 4));
  require_done(camera->start());
  for (int i = 0; i < 4; ++i) require_done(camera->queue({.exposure = milliseconds(5)}));
  int matched = 0;
  for (int i = 0; i < 20; ++i) {
    Edge edge{};
    do edge = value_of(strobe->wait_edge(kPatience));
    while (!edge.rising);
    {
      const CapturedBuffer buffer = value_of(camera->wait(kPatience));
      // The driver stamps the first bytes of a frame, the strobe rises just before they leave.
      const double after_s = to_seconds(buffer.timestamp - edge.at);
      matched += after_s > 0 && after_s < 0.03 ? 1 : 0;
    }
    require_done(camera->queue({.exposure = milliseconds(5)}));
  }
  CHECK(matched >= 15);
}

}  // namespace
}  // namespace hdrcam::hil
