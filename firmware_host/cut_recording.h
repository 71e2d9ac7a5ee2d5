// What makes a whole recording of one that was cut. Reentrant.
#pragma once

#include <cstdint>
#include <string>

#include "hal/core/result.h"

namespace hdrcam {

// The error that cut the recording at `path` after so many whole frames, with how they become a complete one;
// as it is where there are none, or no file any more.
Error cut_recording(Error error, const std::string& path, std::uint64_t frames);

// The error of a reader that came to the cut of the recording at `path`, with how the frames before it become
// a complete one.
Error read_to_cut(Error error, const std::string& path);

}  // namespace hdrcam
