// The sinks of one run, opened from the settings. A slow sink gets a queue and a thread (async_sink.h), so
// that emit() passes a frame to all of them without waiting. Thread-bound.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "firmware_host/run_pace.h"
#include "firmware_host/sinks/sink_table.h"

namespace hdrcam {

// Where a run with these paths leaves its pictures: the HDR frames where they are pictures, else the
// previews.
PicturePatterns patterns_of(const std::map<std::string, std::string, std::less<>>& paths);

// Whether sinks that may leave out frames get one.
enum class Previews { Written, LeftOut };

class SinkSet {
 public:
  // paths: by name of the sink; "" or missing: not wanted. The rest of the request is the same for all.
  // Errors: Invalid for an unusable path, and those of the disk.
  static Result<SinkSet> open(std::span<const SinkKind> kinds,
                              const std::map<std::string, std::string, std::less<>>& paths,
                              const SinkRequest& request, RunPace pace);

  // Errors: the first one of any sink.
  Result<void> emit(const EmittedFrame& frame, Previews previews = Previews::Written);
  // Finishes every sink, also after an error of one of them. Returns the first error.
  Result<void> finish();
  // Concludes every sink, also after an error of one of them. Returns the first error.
  Result<void> conclude(const RunRecord& record);

  // Whether a sink of that name is open and none of its calls failed.
  bool is_whole(std::string_view name) const;
  bool empty() const { return open_.empty(); }
  bool has_previews() const;
  std::vector<SinkTimes> times() const;

 private:
  struct Open {
    const char* name;
    std::unique_ptr<FrameSink> sink = nullptr;
    const AsyncSink* async = nullptr;  // the same one, where it has a thread
    SinkTimes here = {};               // where it has none
    SinkPace pace = SinkPace::Light;
    int left_out = 0;  // frames that emit() kept from it
    bool failed = false;
  };
  static Result<void> noted(Result<void> done, Open& open);  // done, and open.failed where it is an error

  std::vector<Open> open_;
};

}  // namespace hdrcam
