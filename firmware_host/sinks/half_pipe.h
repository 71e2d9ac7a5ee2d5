// HDR frames as bare samples into a pipe: rows from the top, pixels from the left, R G B, IEEE 754 half,
// little endian, scene-linear radiance; nothing between frames. Whoever reads knows the size (`hdrcam info`).
// Thread-bound.
#pragma once

#include <memory>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"

namespace hdrcam {

// emit() returns SizeChanged for a frame of another size than the first one has, and the errors of the pipe.
std::unique_ptr<FrameSink> create_half_pipe(std::unique_ptr<StorageFile> pipe);

}  // namespace hdrcam
