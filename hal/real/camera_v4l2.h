// A camera behind a V4L2 capture node, without libcamera: USB cameras, sensors whose raw frames come straight
// from the receiver (with the sensor's sub-device found through the media graph), and drivers that take a
// control with each frame (request API). Timestamps are the driver's: of the end of the frame for most, of
// its start for USB cameras.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/camera.h"
#include "hal/clock.h"
#include "hal/real/device_node.h"
#include "hal/real/exposure_control.h"

namespace hdrcam {

struct V4l2Options {
  std::optional<PrivateExposureControl> exposure_control{};      // instead of the standard ones
  std::vector<std::string> media_nodes = device_nodes("media");  // where its sensor is looked for
};

// node: "/dev/video0". NotFound, Permission, Unsupported (not a camera), Unplugged. A camera that another
// program streams from opens; its configure() answers Busy and names the program. That of a camera that needs
// a sensor, which may be behind a media node that this user may not open, answers Permission.
Result<std::unique_ptr<Camera>> open_v4l2_camera(const std::string& node, const V4l2Options& options = {},
                                                 Clock& clock = posix_clock());

}  // namespace hdrcam
