// From settings to a camera that is ready to run: which device, which of its modes, which cycle. Everything
// that a user can get wrong about a camera is said here, before it starts. Reentrant.
#pragma once

#include <memory>
#include <string>

#include "capture/capture_stage.h"
#include "firmware_host/settings/settings.h"
#include "hal/camera.h"
#include "hal/storage.h"
#include "hal/sync_line.h"

namespace hdrcam {

struct CaptureSetup {
  CaptureOptions options;
  std::vector<Exposure> cycle;
  Mains mains = Mains::Off;
};

// id: "sim:SCENE", "replay:FILE", or a device (hal/real/enumerate.h); empty: the only device. Errors: those
// of opening it.
Result<std::unique_ptr<Camera>> open_camera(const std::string& id, Storage& storage);
bool is_replayed(const std::string& id);
// The recording that such a camera replays.
std::string replayed_file(const std::string& id);

// Null where no line is set.
Result<std::unique_ptr<SyncLine>> open_strobe(const Settings::Sync& sync);

// The mode that the settings mean. Where no format is named: the one that keeps most of the sensor's codes
// (raw before processed, more bits before fewer); where no size is: the largest of up to 640x480. Errors:
// Unsupported, listing what the camera has.
Result<StreamMode> mode_for(const Settings::Camera& wanted, const CameraCapabilities& camera);

// Errors: Invalid for a text that is no duration, cycle or delay, and those of mode_for.
Result<CaptureSetup> capture_setup(const Settings& settings, const CameraCapabilities& camera);

// "2,1": frames of exposure and gain; "2": of both. Invalid.
Result<ControlDelays> parse_delays(std::string_view text);

}  // namespace hdrcam
