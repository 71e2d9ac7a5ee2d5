// The sinks of one run, opened from the settings. A slow sink gets a queue and a thread (async_sink.h), so
// that emit() passes a frame to all of them without waiting. Thread-bound.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware_host/run_pace.h"
#include "firmware_host/sinks/output_paths.h"
#include "firmware_host/sinks/sink_table.h"

namespace hdrcam {

// Where a run with these paths leaves its pictures: the HDR frames where they are pictures, else the
// previews.
PicturePatterns patterns_of(const OutputPaths& paths);

// Whether sinks that may leave out frames get one.
enum class Previews { Written, LeftOut };

class SinkSet {
 public:
  // kinds: outlive the set. request: the same for all, but for its path and patterns. Errors: Invalid for an
  // unusable path, and those of the disk.
  static Result<SinkSet> open(std::span<const SinkKind> kinds, const OutputPaths& paths,
                              const SinkRequest& request, RunPace pace);

  // Errors: the first one of any sink.
  Result<void> emit(const EmittedFrame& frame, Previews previews = Previews::Written);
  // Finishes every sink, also after an error of one of them or what it throws. The first of these is
  // returned, or thrown.
  Result<void> finish();
  // Concludes every sink, likewise.
  Result<void> conclude(const RunRecord& record);

  // One line for each output that is whole: where it is, and how many frames. Of numbered frames each is a
  // file of its own, so that those before a failure count. What an earlier run left is none. storage: that of
  // the request.
  std::string whole_outputs(Storage& storage) const;
  bool empty() const { return open_.empty(); }
  bool has_previews() const;
  std::vector<SinkTimes> times() const;

 private:
  struct Open {
    const SinkKind* kind;
    std::string path;
    std::unique_ptr<FrameSink> sink = nullptr;
    const AsyncSink* async = nullptr;  // the same one, where it has a thread
    SinkTimes here = {};               // where it has none
    int left_out = 0;                  // frames that emit() kept from it
    FileFacts earlier = {};            // what stood at its name before
    bool failed = false;
  };
  Result<void> each(const std::function<Result<void>(FrameSink&)>& work);
  static SinkTimes times_of(const Open& open);
  static bool is_written(const Open& open, Storage& storage);  // by this run

  std::vector<Open> open_;
};

}  // namespace hdrcam
