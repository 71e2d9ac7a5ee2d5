// A sink on a thread of its own behind a bounded queue, so that a slow one (an EXR of 640x480 takes 50 ms)
// costs the pipeline a copy and no more. Order is kept; the sink sees what it would have seen, a little
// later. What happens when the queue is full is declared: WhenFull. The queue's frames are used again and
// again. Thread-bound; its thread alone calls the sink until finish() has joined it.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/core/thread_priority.h"

namespace hdrcam {

enum class WhenFull {
  Wait,       // emit() waits: every frame arrives
  DropFrame,  // the frame is left out, and counted: for what people look at while a camera runs
};

class AsyncSink : public FrameSink {
 public:
  static constexpr int kDepth = 2;  // frames that wait, besides the one at work

  AsyncSink(std::unique_ptr<FrameSink> sink, WhenFull when_full, ThreadPriority priority);
  ~AsyncSink() override;  // as finish(), its error unseen
  AsyncSink(const AsyncSink&) = delete;
  AsyncSink& operator=(const AsyncSink&) = delete;

  // Errors: the first one of the sink, which may be that of an earlier frame.
  Result<void> emit(const EmittedFrame& frame) override;
  // Everything that waits is done, or given up after an error; then the sink's own finish(), here.
  Result<void> finish() override;
  Result<void> conclude(const RunRecord& record) override { return sink_->conclude(record); }

  // Of the frames so far; times are of the sink's thread.
  SinkTimes times() const;

 private:
  struct Slot {
    HdrFrame hdr;
    ExposedFrame input;
    FrameRecord record;
  };
  static constexpr std::size_t kSlots = kDepth + 1;

  void work();
  void end();

  const std::unique_ptr<FrameSink> sink_;
  const WhenFull when_full_;
  std::vector<Slot> slots_;  // a ring; the oldest one in use is the one at work

  mutable std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::size_t begin_ = 0, count_ = 0;
  bool closed_ = false;
  Result<void> result_;
  SinkTimes times_;
  std::thread thread_;
};

}  // namespace hdrcam
