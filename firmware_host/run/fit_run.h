// One run of the pipeline into its outputs, whatever its frames come from, and the record of what it did.
// Thread-bound; that thread flushes denormals (hal/core/cpu.h) if it wants the speed of it.
#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "firmware_host/run/outputs.h"
#include "firmware_host/run/pipeline.h"
#include "firmware_host/settings/settings.h"

namespace hdrcam {

// A clip ends, and its record tells of every frame. A camera may run for weeks: the record keeps the latest
// frames, in memory that is there from the start, and the threads of the fit stand back behind capture.
enum class FrameSource { Clip, Camera };

class FitRun {
 public:
  static constexpr std::size_t kFramesKept = 2048;  // the latest of a camera

  // title: of the report; command: as it could be typed again.
  // emitted: called for each frame that left.
  static Result<std::unique_ptr<FitRun>> open(const Settings& settings, const CameraFacts& camera,
                                              std::string title, std::string command, Storage& storage,
                                              std::function<void(FrameRecord&)> emitted, FrameSource source);

  // Errors: those of Pipeline::take and of the disk.
  Result<void> take(const RawFrame& frame);
  // The stream has ended: emits what is still on its way and completes frames and previews. TooShort for
  // fewer than two frames.
  Result<void> finish();
  // Writes what tells of the whole run; record() may be added to before.
  Result<void> conclude();

  RunRecord& record() { return record_; }
  const Pipeline& pipeline() const { return pipeline_; }

 private:
  FitRun(const PipelineOptions& options, const CameraFacts& camera, int threads, FrameSource source,
         Outputs outputs, std::function<void(FrameRecord&)> emitted);
  Result<void> deliver(const HdrFrame& frame, const ExposedFrame& input, const FrameRecord& facts);

  WorkerPool pool_;
  Pipeline pipeline_;
  Outputs outputs_;
  RunRecord record_;
  const std::size_t frames_kept_;
  std::function<void(FrameRecord&)> emitted_;
  const Pipeline::Deliver deliver_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

// The flags that make the same fit and outputs, for the record: " --preset balanced --emit merged ...".
std::string flags_of(const Settings::Fit& fit);

}  // namespace hdrcam
