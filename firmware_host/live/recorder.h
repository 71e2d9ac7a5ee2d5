// Writes captured frames to a recording on a thread of its own, in order, every one of them: the queue has
// room for the whole frame pool, so it can never be the one to drop. Thread-safe.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "firmware_host/live/frame_pool.h"
#include "hal/recording/recording.h"

namespace hdrcam {

class Recorder {
 public:
  // frames: of the pool. written: called after each frame, on the recorder's thread.
  Recorder(std::unique_ptr<RecordingWriter> recording, int frames, std::function<void()> written);
  ~Recorder();  // as finish(), its error unseen
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Never waits. After a failure frames are given back unwritten.
  void put(FrameShare frame);
  bool failed() const;
  // Writes what waits, then the end of the recording. Errors: the first one of the writer.
  Result<void> finish();

 private:
  void work();
  FrameShare next();

  std::unique_ptr<RecordingWriter> recording_;
  std::function<void()> written_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<FrameShare> ring_;
  std::size_t begin_ = 0, count_ = 0;
  bool closed_ = false;
  Result<void> result_;
  std::thread thread_;
};

}  // namespace hdrcam
