// Depth as 16-bit grey PNGs, one per frame: camera z in thousandths of the unit of length (millimetres where
// poses are given), 0 where it is unknown or beyond 65.535. The EXR layer Z has no such limits. Thread-bound.
#pragma once

#include <memory>
#include <string_view>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"

namespace hdrcam {

// pattern: "out/depth/%06d.png"; its folder is created. The storage outlives the sink. Errors: Invalid
// (pattern), Permission, NoSpace, Io.
Result<std::unique_ptr<FrameSink>> create_depth_pictures(Storage& storage, std::string_view pattern);

}  // namespace hdrcam
