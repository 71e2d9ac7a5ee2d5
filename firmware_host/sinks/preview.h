// HDR frames as tone-mapped 8-bit PNG files, one per frame, for viewing: one tone curve for the whole clip
// (render/tone_curve.h), so flicker in the preview is flicker in the frames. Thread-bound.
#pragma once

#include <memory>
#include <string_view>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"

namespace hdrcam {

// pattern: "out/%06d.png" (frame_pattern.h); its folder is created. The storage outlives the sink.
// Errors: Invalid (pattern), Permission, NoSpace, Io.
Result<std::unique_ptr<FrameSink>> create_preview(Storage& storage, std::string_view pattern);

}  // namespace hdrcam
