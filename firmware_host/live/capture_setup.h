// Turns settings into a camera that is ready to run: device, mode, cycle. All mistakes in the camera settings
// are reported here, before it starts. Reentrant.
#pragma once

#include <memory>
#include <string>

#include "capture/capture_stage.h"
#include "firmware_host/settings/settings.h"
#include "hal/camera.h"
#include "hal/sim/simulated_camera.h"
#include "hal/storage.h"

namespace hdrcam {

struct CaptureSetup {
  CaptureOptions options;
  std::vector<Exposure> cycle;
  Mains mains = Mains::Off;
};

// id: "sim:SCENE", "replay:FILE", or a device (hal/real/enumerate.h); empty: the only device. wiring: of a
// simulated one. Errors: those of opening it.
Result<std::unique_ptr<Camera>> open_camera(const std::string& id, Storage& storage,
                                            const SimulatedWiring& wiring = {});
bool is_simulated(const std::string& id);
bool is_replayed(const std::string& id);
// The recording of a camera "replay:FILE".
std::string replayed_file(const std::string& id);

// The stream mode for the settings. Default format: the highest bit depth available (raw before processed,
// more bits before fewer), of those that have a size that is set, where any has; default size: the largest of
// up to 640x480. Errors: Unsupported, listing what the camera has.
Result<StreamMode> mode_for(const Settings::Camera& wanted, const CameraCapabilities& camera);
// Of a camera that took this mode, its sizes in the mode's format: "320x240, 640x480"; empty where it lists
// fewer than two, or not the size that it took: one that scales has more than it lists.
std::string sizes_of(const CameraCapabilities& camera, const StreamMode& taken);

// Errors: Invalid for a text that is not a duration, cycle or delay, and those of mode_for.
Result<CaptureSetup> capture_setup(const Settings& settings, const CameraCapabilities& camera);

// Parses "2,1" as frames of exposure and gain, "2" as both. Invalid.
Result<ControlDelays> parse_delays(std::string_view text);

}  // namespace hdrcam
