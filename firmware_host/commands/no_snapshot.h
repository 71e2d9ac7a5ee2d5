// What every verb that reads a recording says of a snapshot of a scene (docs/snapshot.md). Reentrant.
#pragma once

#include <string>

#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// Before the file is opened as a recording or as footage: only then is it found out whether it is there, and
// what else it is. Errors: NotRecording for a snapshot; those of reading its first bytes.
Result<void> check_no_snapshot(Storage& storage, const std::string& file);

}  // namespace hdrcam
