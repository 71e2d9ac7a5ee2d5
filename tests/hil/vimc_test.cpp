// The kernel's virtual sensor, with the controls of a real one (modules/patch_vimc.py): through V4L2 with its
// sub-device, and through libcamera.
#include "hal/real/camera_libcamera.h"
#include "hal/real/camera_v4l2.h"
#include "tests/contracts/camera_contract.h"
#include "tests/contracts/expect.h"
#include "tests/hil/bed.h"

namespace hdrcam::hil {
namespace {

using std::chrono::milliseconds;

constexpr StreamMode kRaw{PixelFormat::Rggb12, 640, 480, milliseconds(33)};
constexpr const char* kRawNode = "Raw Capture 0";

TEST_CASE("a sensor behind a media graph keeps the camera contract") {
  keeps_camera_contract({.name = "vimc, raw",
                         .open = [] { return open_v4l2_camera(video_node(kRawNode)); },
                         .mode = kRaw,
                         .frames = 20,
                         .drops_frames = true});
}

TEST_CASE("exposure and gain of a sensor sub-device act on the raw picture") {
  auto camera = value_of(open_v4l2_camera(video_node(kRawNode)));
  const StreamMode mode = value_of(camera->configure(kRaw, 4));
  CHECK(mode.format == PixelFormat::Rggb12);
  const CameraCapabilities& has = camera->capabilities();
  CHECK(has.model.find("Sensor A") != std::string::npos);
  REQUIRE(has.sets_exposure);
  CHECK(has.exposure_step.count() == 31'746'032);  // ps; (640 + 160) pixels at 25.2 MHz
  CHECK(has.gain_min == Approx(1));
  CHECK(has.gain_max == Approx(16));
  CHECK(to_seconds(mode.frame_duration) == Approx(0.033).margin(1e-4));
  require_done(camera->start());
  const auto settled_mean = [&](int steps, double gain) {
    const auto exposure = std::chrono::round<Duration>(steps * has.exposure_step);
    double mean = 0;
    for (int i = 0; i < 4; ++i)
      require_done(camera->queue({.cookie = 0, .exposure = exposure, .analogue_gain = gain}));
    for (int i = 0; i < 4; ++i) mean = mean_code(value_of(camera->wait(std::chrono::seconds(5))));
    return mean;
  };
  const double dark = settled_mean(100, 1);
  const double twice = settled_mean(200, 1);
  const double amplified = settled_mean(100, 4);
  CHECK(twice / dark == Approx(2).margin(0.1));
  CHECK(amplified / dark == Approx(4).margin(0.2));
}

TEST_CASE("libcamera's vimc keeps the camera contract") {
  keeps_camera_contract({.name = "vimc, libcamera",
                         .open = [] { return open_libcamera_camera("Sensor B"); },
                         .mode = {PixelFormat::Bgr24, 318, 240, milliseconds(33)},
                         .patience = std::chrono::seconds(5),
                         .frames = 20,
                         .drops_frames = true,
                         .allocations_per_frame = 60});
}

}  // namespace
}  // namespace hdrcam::hil
