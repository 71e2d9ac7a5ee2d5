// What makes a whole recording of one whose end could not be written. Reentrant.
#pragma once

#include <cstdint>
#include <string>

#include "hal/core/result.h"

namespace hdrcam {

// The error that cut the recording at `path` after so many whole frames, with how they become a complete one;
// as it is where there are none.
Error cut_recording(Error error, const std::string& path, std::uint64_t frames);

}  // namespace hdrcam
