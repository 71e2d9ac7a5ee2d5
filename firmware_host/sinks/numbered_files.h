// A sink of one file per frame, named by the frame's number; what is in the file is the caller's.
// Thread-bound.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"

namespace hdrcam {

// Writes one frame's file.
using WriteFrame = std::function<Result<void>(const EmittedFrame&, Storage&, const std::string& path)>;

// Makes the folder. flag, pattern, extension: as FramePattern::parse takes them. Errors: those of parse() and
// of the storage; emit() returns those of `write`, and of the first frame Exists where another run has
// written files of such names since.
Result<std::unique_ptr<FrameSink>> create_numbered_files(Storage& storage, std::string_view flag,
                                                         std::string_view pattern, std::string_view extension,
                                                         WriteFrame write);

}  // namespace hdrcam
