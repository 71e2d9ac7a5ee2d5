// Motion as Middlebury .flo files, one per frame, for optical-flow tools: "PIEH" (the float 202021.25), width
// and height as 32-bit integers, then u and v of each pixel as 32-bit floats, row by row, all little-endian;
// above 1e9 a value is unknown. u to the right, v down, pixels. The values are those of the EXR layers. A
// frame without that neighbour has a file in which all is unknown, so that the numbers have no gaps. The sink
// is thread-bound.
// Source: vision.middlebury.edu/flow/code/flow-code/README.txt.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"

namespace hdrcam {

inline constexpr float kUnknownFlow = 1e10f;

// flow: [dx dy, rows, cols]; an empty one gives unknown vectors everywhere. Reentrant.
std::vector<std::byte> encode_flo(const Image<float>& flow, int rows, int cols);

// layer: the motion that is written. flag: of the pattern, for messages; pattern: "out/%06d.flo"; its folder
// is created. The storage outlives the sink. Errors: Invalid (pattern), Permission, NoSpace, Io.
Result<std::unique_ptr<FrameSink>> create_flow_files(Storage& storage, std::string_view flag,
                                                     std::string_view pattern, Image<float> HdrFrame::*layer);

}  // namespace hdrcam
