// Cameras of libcamera: raw and processed streams, exposure and gain with each request, automatics off, a
// constant frame duration where the pipeline has one, and the metadata of completed requests. In a build
// without libcamera every call answers Unsupported and says what to install.
//
// Two kinds of pipeline: one with image processing algorithms on the host (Raspberry Pi, Rockchip, IPU3)
// applies controls to the frame of their own request and reports what the frame got; one without (USB
// cameras) writes a control to the device when the request is *queued* and reports nothing. For the second
// kind the exposure is paced (control_pacer.h): a request carries the exposure of the frame that comes next,
// so that the delay is that of the device.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/camera.h"
#include "hal/clock.h"

namespace hdrcam {

// libcamera tells much on the standard error stream; nothing of it is shown unless this is asked or the
// environment variable LIBCAMERA_LOG_LEVELS is set. Before the first camera.
void show_libcamera_log();

// What it finds, without opening any. Empty: no camera, or none that this user may open.
Result<std::vector<CameraCapabilities>> list_libcamera_cameras();

// id: as listed, or a part of an id or model that only one has. NotFound, Busy, Permission, Unsupported.
Result<std::unique_ptr<Camera>> open_libcamera_camera(const std::string& id, Clock& clock = posix_clock());

}  // namespace hdrcam
