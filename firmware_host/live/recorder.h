// Writes every captured frame to a recording, in order, on its own thread: the queue has room for the whole
// frame pool, so the recorder never drops a frame. Thread-safe.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "firmware_host/live/frame_pool.h"
#include "hal/core/trace.h"
#include "hal/recording/recording.h"

namespace hdrcam {

class Recorder {
 public:
  // frames: of the pool. written: called after each frame, on the recorder's thread. trace: null, or outlives
  // the recorder.
  Recorder(std::unique_ptr<RecordingWriter> recording, int frames, std::function<void()> written,
           Trace* trace = nullptr);
  ~Recorder();  // like finish(), but ignores the error
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Never waits. After a failure frames are returned unwritten. False after close().
  bool put(FrameShare frame);
  // No more frames: the recorder's thread writes those in the queue and the end of the recording.
  void close();
  // Of the work so far: the first error of the writer.
  Result<void> outcome() const;
  bool ended() const;  // everything is written, or nothing more will be
  // Writes all queued frames, then the end of the recording. Errors: the first one of the writer.
  Result<void> finish();

 private:
  void work();
  FrameShare next();

  std::unique_ptr<RecordingWriter> recording_;  // of its thread; null once it is complete
  std::function<void()> written_;
  Trace* const trace_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<FrameShare> ring_;
  std::size_t begin_ = 0, count_ = 0;
  bool closed_ = false, ended_ = false;
  Result<void> result_;
  std::thread thread_;
};

}  // namespace hdrcam
