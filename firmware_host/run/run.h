// One run of the method, the only place where source, method and sinks are joined: run.cpp follows a frame
// from top to bottom. `replay` and `live` differ only in their source.
#pragma once

#include <atomic>
#include <cstdio>
#include <span>
#include <string>

#include "firmware_host/run/frame_source.h"
#include "firmware_host/settings/settings.h"
#include "firmware_host/sinks/sink_table.h"

namespace hdrcam {

struct FilmPlan;
struct RunRecord;

struct RunPlan {
  Settings settings = {};
  std::string title = {};          // of the report
  std::string command = {};        // to type it again
  const FilmPlan* film = nullptr;  // what a virtual camera films of the frames; null: the frames as they are
  std::string truth = {};          // a clip with ground truth, to score the HDR frames against; "" for none
  std::span<const SinkKind> sinks = sink_kinds();
  const std::atomic<bool>* stop = nullptr;  // ends the film and the scoring
  std::FILE* progress = stderr;             // stream of the progress line; null for none
  Trace* trace = nullptr;                   // gets stages and frames; null, or outlives the run
  RunRecord* record = nullptr;              // gets the record of the run; null, or outlives it
};

// Runs until the source ends; the work is done on separate threads, the caller's shows the progress. However
// a run ends, frames emitted before are complete. Errors: those of the settings, of the disk, of the frames
// (BadExposure, SizeChanged, TooShort) and of the source.
Result<void> run(const RunPlan& plan, FrameSource& source, Storage& storage);

}  // namespace hdrcam
