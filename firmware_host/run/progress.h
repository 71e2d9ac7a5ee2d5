// The progress of a run in one line (status_line.h):
//   frame 12/48  61 ms/frame  loss 0.021  ETA 00:03
// Before the first frame of a film, which may be far into the recording:
//   recorded frame 17  260 ms/frame
// Thread-bound.
#pragma once

#include <cstdio>
#include <future>
#include <mutex>
#include <optional>

#include "firmware_host/run/frame_source.h"
#include "firmware_host/run/progress_state.h"
#include "firmware_host/status_line.h"
#include "hal/core/result.h"

namespace hdrcam {

class Progress {
 public:
  using Clock = StatusLine::Clock;

  Progress(std::FILE* stream, std::optional<int> total) : line_(stream) { state_.total = total; }

  // Counts a finished frame. It updates the line when one is due, and always for the last frame.
  void frame_done(double ms, std::optional<double> loss, Clock::time_point now = Clock::now());

 private:
  StatusLine line_;
  ProgressState state_;
};

// The progress of a run: written by the working thread, read by the one that shows it. Thread-safe.
class SharedProgress {
 public:
  explicit SharedProgress(std::optional<int> total) { state_.total = total; }
  void frame_done(double ms, std::optional<double> loss) {
    const std::lock_guard lock(mutex_);
    state_.frame_done(ms, loss);
  }
  void frame_read(double ms) {
    const std::lock_guard lock(mutex_);
    state_.frame_read(ms);
  }
  ProgressState now() const {
    const std::lock_guard lock(mutex_);
    return state_;
  }

 private:
  mutable std::mutex mutex_;
  ProgressState state_;
};

// Rewrites the line that says how far the run is until the work is done.
void show_progress(std::FILE* stream, const FrameSource& source, const SharedProgress& progress,
                   const std::future<Result<void>>& work);

}  // namespace hdrcam
