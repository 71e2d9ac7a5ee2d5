#include "firmware_host/live/fit_inbox.h"

#include <algorithm>

namespace hdrcam {

int FitInbox::put(FrameShare frame) {
  int shed = 0;
  {
    const std::lock_guard lock(mutex_);
    if (count_ == capacity_) drop_front(1), shed = 1;
    frames_[count_++] = std::move(frame);
  }
  changed_.notify_one();
  return shed;
}

FitInbox::Taken FitInbox::take(Duration timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return count_ > 0 || closed_; });
  if (count_ == 0) return {};
  const std::size_t chosen = next();
  Taken taken{std::move(frames_[chosen]), static_cast<int>(chosen)};
  drop_front(chosen + 1);
  last_slot_ = taken.frame->captured.raw.facts.slot;
  return taken;
}

std::size_t FitInbox::next() const {
  if (last_slot_ < 0) return 0;
  const int wanted = (last_slot_ + 1) % slots_;
  for (std::size_t i = count_; i-- > 0;)
    if (frames_[i]->captured.raw.facts.slot == wanted) return i;
  return 0;
}

// Returns the shed frames to the pool and moves the others up.
void FitInbox::drop_front(std::size_t count) {
  std::move(frames_.begin() + static_cast<std::ptrdiff_t>(count),
            frames_.begin() + static_cast<std::ptrdiff_t>(count_), frames_.begin());
  for (std::size_t i = count_ - count; i < count_; ++i) frames_[i] = {};
  count_ -= count;
}

void FitInbox::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

bool FitInbox::ended() const {
  const std::lock_guard lock(mutex_);
  return closed_ && count_ == 0;
}

}  // namespace hdrcam
