// Writes every captured frame to a recording, in order, on its own thread: the queue has room for the whole
// frame pool, so the recorder never drops a frame. What the writer throws, such as std::bad_alloc, fails the
// recording as an error of its does: it is closed behind the frames before. Thread-safe.
#pragma once

#include <condition_variable>
#include <exception>
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
  ~Recorder();  // as complete()
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Never waits. After a failure frames are returned unwritten. False after close().
  bool put(FrameShare frame);
  // No more frames: the recorder's thread writes those in the queue and the end of the recording.
  void close();
  bool failed() const;  // so far
  // Of the work so far: the first error of the writer; what it threw is thrown here.
  Result<void> outcome() const;
  bool ended() const;  // everything is written, or nothing more will be
  // Waits until all queued frames are written, and the end of the recording.
  void complete();
  // The same, then its outcome().
  Result<void> finish() { return complete(), outcome(); }

 private:
  void work();
  Result<void> write_frames();
  FrameShare next();
  bool has_failed() const { return !result_ || thrown_ != nullptr; }  // under the lock

  std::unique_ptr<RecordingWriter> recording_;  // of its thread; null once it is complete
  std::function<void()> written_;
  Trace* const trace_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<FrameShare> ring_;
  std::size_t begin_ = 0, count_ = 0;
  bool closed_ = false, ended_ = false;
  Result<void> result_;
  std::exception_ptr thrown_;  // by the writer
  std::thread thread_;
};

}  // namespace hdrcam
