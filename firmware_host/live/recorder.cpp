#include "firmware_host/live/recorder.h"

namespace hdrcam {

Recorder::Recorder(std::unique_ptr<RecordingWriter> recording, int frames, std::function<void()> written)
    : recording_(std::move(recording)),
      written_(std::move(written)),
      ring_(static_cast<std::size_t>(frames)),
      thread_([this] { work(); }) {}

Recorder::~Recorder() { (void)finish(); }

void Recorder::put(FrameShare frame) {
  {
    const std::lock_guard lock(mutex_);
    if (!result_) return;
    CHECK_LT(count_, ring_.size());
    ring_[(begin_ + count_++) % ring_.size()] = std::move(frame);
  }
  changed_.notify_one();
}

bool Recorder::failed() const {
  const std::lock_guard lock(mutex_);
  return !result_.ok();
}

Result<void> Recorder::finish() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
  return result_;
}

FrameShare Recorder::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return count_ > 0 || closed_; });
  if (count_ == 0) return {};
  FrameShare frame = std::move(ring_[begin_]);
  begin_ = (begin_ + 1) % ring_.size(), --count_;
  return frame;
}

void Recorder::work() {
  Result<void> result;
  while (const FrameShare frame = next()) {
    result = recording_->append(frame->captured.raw);
    if (!result) break;
    written_();
  }
  // Also after a failure: it closes the frames written before as well as possible.
  const Result<void> finished = recording_->finish();
  if (result) result = finished;
  const std::lock_guard lock(mutex_);
  result_ = std::move(result);
  while (count_ > 0) {
    ring_[begin_] = {};
    begin_ = (begin_ + 1) % ring_.size(), --count_;
  }
}

}  // namespace hdrcam
