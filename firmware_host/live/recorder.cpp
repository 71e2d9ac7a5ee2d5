#include "firmware_host/live/recorder.h"

#include "hal/core/thread_name.h"
#include "hal/core/thrown_by.h"

namespace hdrcam {

Recorder::Recorder(std::unique_ptr<RecordingWriter> recording, int frames, std::function<void()> written,
                   Trace* trace)
    : recording_(std::move(recording)),
      written_(std::move(written)),
      trace_(trace),
      ring_(static_cast<std::size_t>(frames)),
      thread_([this] {
        name_this_thread("recorder");
        work();
      }) {}

Recorder::~Recorder() { complete(); }

bool Recorder::put(FrameShare frame) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return false;
    if (has_failed()) return true;
    HDRCAM_CHECK_LT(count_, ring_.size());
    ring_[(begin_ + count_++) % ring_.size()] = std::move(frame);
  }
  changed_.notify_one();
  return true;
}

void Recorder::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_one();
}

bool Recorder::failed() const {
  const std::lock_guard lock(mutex_);
  return has_failed();
}

Result<void> Recorder::outcome() const {
  const std::lock_guard lock(mutex_);
  if (thrown_ != nullptr) std::rethrow_exception(thrown_);
  return result_;
}

bool Recorder::ended() const {
  const std::lock_guard lock(mutex_);
  return ended_;
}

void Recorder::complete() {
  close();
  if (thread_.joinable()) thread_.join();
}

FrameShare Recorder::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return count_ > 0 || closed_; });
  if (count_ == 0) return {};
  FrameShare frame = std::move(ring_[begin_]);
  begin_ = (begin_ + 1) % ring_.size(), --count_;
  return frame;
}

Result<void> Recorder::write_frames() {
  while (const FrameShare frame = next()) {
    const TraceSpan span(trace_, "record", static_cast<std::int64_t>(frame->captured.raw.facts.sequence));
    TRY(recording_->append(frame->captured.raw));
    written_();
  }
  return {};
}

void Recorder::work() {
  Result<void> result, finished;
  std::exception_ptr thrown = thrown_by([&] { result = write_frames(); });
  // Also after a failure: it closes the frames written before as well as possible.
  std::exception_ptr thrown_at_end = thrown_by([&] { finished = recording_->finish(); });
  if (result && thrown == nullptr) result = std::move(finished), thrown = std::move(thrown_at_end);
  recording_.reset();  // the run may go on for long: the file is nobody's any more
  const std::lock_guard lock(mutex_);
  result_ = std::move(result), thrown_ = std::move(thrown);
  ended_ = true;
  while (count_ > 0) {
    ring_[begin_] = {};
    begin_ = (begin_ + 1) % ring_.size(), --count_;
  }
}

}  // namespace hdrcam
