// Runs a sink on its own thread behind a bounded queue, so that a slow one (an EXR of 640x480 takes 50 ms)
// costs the pipeline only a copy. Order is kept; the sink gets the same frames, a little later. The queue is
// bounded in frames and in bytes, and reuses its frames; WhenFull declares what happens when it is full.
// Thread-bound; its thread alone calls the sink until finish() has joined it.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/core/thread_priority.h"
#include "hal/core/trace.h"

namespace hdrcam {

enum class WhenFull {
  Wait,       // emit() waits: every frame arrives
  DropFrame,  // the frame is left out and counted: for previews while a camera runs
};

class AsyncSink : public FrameSink {
 public:
  static constexpr int kDepth = 2;                          // queued frames, besides the one in work
  static constexpr std::uint64_t kMostBytes = 64ULL << 20;  // of all of them, as long as there is one
  // How many frames of this size it holds, with the one in work.
  static std::size_t slots_for(std::uint64_t frame_bytes);

  // name: of its thread; trace: may be null, else outlives the sink.
  AsyncSink(std::unique_ptr<FrameSink> sink, WhenFull when_full, ThreadPriority priority,
            const std::string& name = "sink", Trace* trace = nullptr);
  ~AsyncSink() override;  // completes the queue as finish() does, but does not finish the sink
  AsyncSink(const AsyncSink&) = delete;
  AsyncSink& operator=(const AsyncSink&) = delete;

  // Errors: the sink's first error, possibly from an earlier frame. What the sink threw on its thread, such
  // as std::bad_alloc, is thrown here and by finish().
  Result<void> emit(const EmittedFrame& frame) override;
  // Completes all queued frames, or drops them after an error; then calls the sink's finish() here.
  Result<void> finish() override;
  Result<void> conclude(const RunRecord& record) override { return sink_->conclude(record); }
  InputUse input_use() const override { return input_use_; }

  // Statistics of the frames so far; times are of the sink's thread.
  SinkTimes times() const;

 private:
  struct Slot {
    HdrFrame hdr;
    ExposedFrame input;
    FrameRecord record;
  };

  void work();
  void end();
  // Under the lock, or once the thread has ended.
  bool failed() const { return !result_ || thrown_ != nullptr; }
  Result<void> failure() const;  // throws what the sink threw

  const std::unique_ptr<FrameSink> sink_;
  const InputUse input_use_;
  const WhenFull when_full_;
  Trace* const trace_;
  std::vector<Slot> slots_;  // a ring, made for the first frame; the oldest one in use is in work

  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::size_t begin_ = 0, count_ = 0;
  bool closed_ = false;
  Result<void> result_;
  std::exception_ptr thrown_;  // by the sink
  SinkTimes times_;
  std::thread thread_;
};

}  // namespace hdrcam
