// The index of an MP4 or MOV: its box "moov", without which no picture of it is read (ISO/IEC 14496-12).
// Reentrant.
#pragma once

#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// Whether the file ends within it; not of a file without one. Errors: those of reading.
Result<bool> is_index_cut(StorageFile& file);

}  // namespace hdrcam
