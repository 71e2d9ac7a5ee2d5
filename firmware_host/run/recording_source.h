// A recording as the source of a run: every frame, as fast as the fit takes them. Thread-bound.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "firmware_host/run/frame_source.h"
#include "hal/storage.h"

namespace hdrcam {

// frames: at most so many, 0 for all. stop: becomes true when the user asks to stop; the run then ends with
// Interrupted, its frames complete. Storage and stop outlive the source. Errors: those of open_recording.
Result<std::unique_ptr<FrameSource>> open_recording_source(Storage& storage, const std::string& path,
                                                           int frames, const std::atomic<bool>& stop);

}  // namespace hdrcam
