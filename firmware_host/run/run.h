// One run of the method, the only place where source, method and sinks are joined: run.cpp reads from top to
// bottom as the way of a frame. `replay` and `live` differ in their source and nothing else.
#pragma once

#include <atomic>
#include <cstdio>
#include <span>
#include <string>

#include "firmware_host/run/frame_source.h"
#include "firmware_host/settings/settings.h"

namespace hdrcam {

struct RunPlan {
  Settings settings = {};
  std::string title = {};    // of the report
  std::string command = {};  // as it could be typed again
  std::string truth = {};    // a clip with ground truth, to score the HDR frames against; "" for none
  std::span<const SinkKind> sinks = sink_kinds();
  const std::atomic<bool>* stop = nullptr;  // ends the scoring
  std::FILE* progress = stderr;             // the line that says how far the run is; null for none
};

constexpr std::size_t kFramesKept = 2048;  // records of frames, the latest, of a run on a camera

// Runs until the source ends; the work is done on threads of its own, the caller's shows the progress.
// However a run ends, what left before is complete. Errors: those of the settings, of the disk and of the
// frames (BadExposure, SizeChanged, TooShort), and why the source ended.
Result<void> run(const RunPlan& plan, FrameSource& source, Storage& storage);

}  // namespace hdrcam
