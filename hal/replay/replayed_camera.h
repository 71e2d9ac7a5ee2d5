// A recording as a camera: it delivers frames as a driver would, with the recorded exposures and instants, so
// that everything from capture/ on runs as it did then. It sets no exposures: requests only mark a buffer as
// free. A frame waits for its request, so none is ever lost but those that are damaged. At the recorded pace,
// a pause of more than a second and more than five frames lasts only that long: nobody who waits for a camera
// takes it for a dead one. The instants stay the recorded ones. After the last frame wait() returns
// Unplugged. Thread-bound, except stop() and the return of buffers.
#pragma once

#include <memory>
#include <string>

#include "hal/camera.h"
#include "hal/clock.h"
#include "hal/replay/replay_pace.h"
#include "hal/storage.h"

namespace hdrcam {

// Storage and clock outlive the camera. Errors: those of open_recording; Unsupported where no pixel format
// holds the codes without loss (RGB above 8 bits, which `hdrcam replay` reads directly).
Result<std::unique_ptr<Camera>> open_replayed_camera(Storage& storage, const std::string& path,
                                                     ReplayPace pace, Clock& clock);

}  // namespace hdrcam
