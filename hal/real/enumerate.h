// Lists this machine's devices, their capabilities, and the obstacles to unusable ones: a missing permission
// or library, another program that holds them. Opens devices briefly; changes nothing. Reentrant.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/camera.h"

namespace hdrcam {

enum class DeviceKind { Camera, GpioChip, Graphics };

struct FoundDevice {
  DeviceKind kind = DeviceKind::Camera;
  std::string id;                  // for --camera, a line setting or --backend; empty where it cannot be used
  std::string title;               // the name to show
  std::vector<std::string> facts;  // a clause each
  std::vector<std::string> missing;  // a sentence each: the obstacle and what to do
};

// Cameras (libcamera's, then V4L2 nodes), GPIO chips, graphics devices.
std::vector<FoundDevice> list_devices();

// id: "/dev/video0", "libcamera:ID", or an id that libcamera knows, whole or in part. Empty: the only camera
// there is. NotFound states that there is no camera and names possible obstacles.
Result<std::unique_ptr<Camera>> open_real_camera(const std::string& id);

}  // namespace hdrcam
