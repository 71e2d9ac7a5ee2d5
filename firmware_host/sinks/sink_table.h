// The sinks that there are. Each has a name, which is its key among the settings (`output.NAME`), a flag, a
// word of help and a function that opens it; everything else about outputs follows from this table: one more
// line is one more sink. Reentrant.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "firmware_host/sinks/async_sink.h"
#include "firmware_host/sinks/exr_sequence.h"
#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"

namespace hdrcam {

// What a sink is opened with.
struct SinkRequest {
  std::string path;  // as the user gave it: a file, or a pattern for one file per frame
  const CameraFacts& camera;
  ExrLayers layers = {};
  ExrCompression compression = ExrCompression::Zip;
  Storage& storage;  // outlives the sink
};

// Where a sink works, and what it does when it cannot keep up with a camera; with a recording the run waits.
enum class SinkPace {
  Light,     // in the thread that emits: it costs next to nothing there
  Complete,  // on a thread of its own; every frame arrives, the fit waits
  Latest,    // on a thread of its own; frames may be left out while a camera runs
};

struct SinkKind {
  const char* name;   // "frames"
  const char* flag;   // "-o,--output"
  const char* about;  // a clause with an example
  SinkPace pace;
  // Errors: Invalid for a path that will not do, and those of the disk.
  Result<std::unique_ptr<FrameSink>> (*open)(const SinkRequest& request);
};

// In the order in which they get a frame, and in which the help lists them.
std::span<const SinkKind> sink_kinds();

}  // namespace hdrcam
