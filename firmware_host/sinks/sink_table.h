// The table of sinks. Each has a name, which is its key in the settings (`output.NAME`), a flag, a help text
// and a function that opens it; everything else about outputs follows from this table: a new sink is a new
// line. Reentrant.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "firmware_host/sinks/async_sink.h"
#include "firmware_host/sinks/dash.h"
#include "firmware_host/sinks/exr_sequence.h"
#include "firmware_host/sinks/frame_sink.h"
#include "firmware_host/sinks/output_paths.h"
#include "firmware_host/sinks/run_control.h"
#include "firmware_host/sinks/scene_files/pose_files.h"
#include "firmware_host/sinks/sink_name.h"
#include "firmware_host/sinks/video_options.h"
#include "hal/storage.h"

namespace hdrcam {

// The arguments for opening a sink.
struct SinkRequest {
  std::string path;  // as the user gave it: a file, a pattern for one file per frame, kStandardOutput, or an
                     // address
  const CameraFacts& camera;  // of the frames; size 0: not known before the first one
  ExrLayers layers = {};
  ExrCompression compression = kUsualCompression;
  VideoOptions video = {};
  Storage& storage;               // outlives the sink
  std::string http_token = {};    // of the live view
  RunControl* control = nullptr;  // of a run on a camera; outlives the sink
  Trace* trace = nullptr;         // outlives the sink
  PicturePatterns patterns = {};  // of the run's pictures; SinkSet fills it in
};

// A sink's thread, and what it does when slower than the camera; with a recording the run waits.
enum class SinkPace {
  Light,     // in the emitting thread, where it costs almost nothing
  Complete,  // on its own thread; every frame arrives, the fit waits
  Latest,    // on its own thread; frames may be left out while a camera runs
};

// What a sink is given as its path.
enum class SinkTarget { Files, Model, Address };  // Model: a folder with the files of a COLMAP model

struct SinkKind {
  std::string_view name;  // sink_name.h
  const char* flag;       // "-o,--output"
  const char* about;      // a clause with an example
  SinkPace pace;
  SinkTarget target;
  // Errors: Invalid for an unusable path, and those of the disk.
  Result<std::unique_ptr<FrameSink>> (*open)(const SinkRequest& request);
  const char* extension = nullptr;  // of one file per frame, ".png"; null where it writes none such
};

// In the order in which they get a frame, and in which the help lists them.
std::span<const SinkKind> sink_kinds();

// Errors: Invalid where frames would go to the standard output, and that is a terminal: it would show their
// bytes, some of which are commands to it. The sink of the frames refuses it, too, once it is opened.
Result<void> check_no_terminal(const OutputPaths& paths);

// The sink of that name by itself, in the caller's thread. Errors: those of its `open`.
Result<std::unique_ptr<FrameSink>> open_sink(std::string_view name, const SinkRequest& request);

}  // namespace hdrcam
