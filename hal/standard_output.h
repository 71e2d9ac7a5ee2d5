// The standard output of this process as a file: it takes bytes in order, is never read and has no size.
// Beside the disk (storage.h), not of it: what goes there is lost to nobody. Thread-safe as any file of the
// storage.
#pragma once

#include <memory>

#include "hal/storage.h"

namespace hdrcam {

std::unique_ptr<StorageFile> standard_output();

}  // namespace hdrcam
