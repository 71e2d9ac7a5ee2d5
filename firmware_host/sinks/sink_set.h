// The sinks of one run, opened as the settings ask. A slow sink gets a queue and a thread (async_sink.h), so
// that emit() hands a frame to all of them and goes on. Thread-bound.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "firmware_host/sinks/sink_table.h"

namespace hdrcam {

// Whom a run waits for: a clip waits for every sink; a camera waits for nobody, so sinks that may leave out
// frames do, and their threads stand back behind capture.
enum class RunPace { Clip, Camera };

class SinkSet {
 public:
  // paths: by name of the sink; "" or missing: not wanted. What else the request holds is the same for all.
  // Errors: Invalid for a path that will not do, and those of the disk.
  static Result<SinkSet> open(std::span<const SinkKind> kinds,
                              const std::map<std::string, std::string, std::less<>>& paths,
                              const SinkRequest& request, RunPace pace);

  // Errors: the first one of any sink.
  Result<void> emit(const EmittedFrame& frame);
  // Every sink is finished, also after an error of one of them; the first error.
  Result<void> finish();
  Result<void> conclude(const RunRecord& record);

  bool empty() const { return open_.empty(); }
  std::vector<SinkTimes> times() const;

 private:
  struct Open {
    const char* name;
    std::unique_ptr<FrameSink> sink = nullptr;
    const AsyncSink* async = nullptr;  // the same one, where it has a thread
    SinkTimes here = {};               // where it has none
  };
  std::vector<Open> open_;
};

}  // namespace hdrcam
