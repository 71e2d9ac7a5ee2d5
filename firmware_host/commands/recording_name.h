// The name of a recording to write, and what is said of it when it is written. Reentrant.
#pragma once

#include <cstdint>
#include <string>

#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// A recording is one Matroska file and is called so, whatever other programs make of a name; a pipe or a
// device may have any. "": none is wanted. Errors: Invalid for any other name; those of Storage::look_at.
Result<void> check_recording_name(Storage& storage, const char* flag, const std::string& path);

// "walk.mkv: 90 frames, 640x480, 8 bits, rgb"
std::string describe_recording(const std::string& path, const CameraFacts& camera, std::uint64_t frames);

}  // namespace hdrcam
