// The name of a recording to write. Reentrant.
#pragma once

#include <string>

#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// A recording is a Matroska file and is called so, whatever other programs make of a name; a pipe or a device
// may have any. "": none is wanted. Errors: Invalid for any other name; those of Storage::look_at.
Result<void> check_recording_name(Storage& storage, const char* flag, const std::string& path);

}  // namespace hdrcam
