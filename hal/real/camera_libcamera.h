// Cameras of libcamera: raw and processed streams, exposure and gain with each request, automatic controls
// off, a constant frame duration where the pipeline has one, and the metadata of completed requests. In a
// build without libcamera every call returns Unsupported and names the package to install.
//
// Two kinds of pipeline: one with image processing algorithms on the host (Raspberry Pi, Rockchip, IPU3)
// applies controls to the frame of their own request and reports the applied values; one without (USB
// cameras) writes a control to the device when the request is *queued* and reports nothing. For the second
// kind the exposure is paced (control_pacer.h): a request carries the exposure of the frame that comes next,
// so that the delay is that of the device.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/camera.h"

namespace hdrcam {

// Shows libcamera's log, which is hidden unless this is called or the environment variable
// LIBCAMERA_LOG_LEVELS is set. Call it before the first camera is opened.
void show_libcamera_log();

// The cameras that libcamera finds; opens none. Empty: no camera, or none that this user may open.
Result<std::vector<CameraCapabilities>> list_libcamera_cameras();

// id: as listed, or a part of an id or model that only one has. NotFound, Busy, Permission, Unsupported.
Result<std::unique_ptr<Camera>> open_libcamera_camera(const std::string& id);

}  // namespace hdrcam
