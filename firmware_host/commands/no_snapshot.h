// What every verb that reads a recording says of a snapshot of a scene (docs/snapshot.md). Reentrant.
#pragma once

#include <string>

#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// Before the file is opened as a recording or as footage, and before the folder of an output is made, which
// may be of that name. Errors: NotFound where nothing is; NotRecording for a snapshot; those of reading its
// first bytes.
Result<void> check_no_snapshot(Storage& storage, const std::string& file);

}  // namespace hdrcam
