#include "firmware_host/live/fit_inbox.h"

#include <algorithm>

#include "hal/core/check.h"

namespace hdrcam {
namespace {

std::size_t two_cycles(int slots) { return 2 * static_cast<std::size_t>(slots) + 1; }

}  // namespace

FitInbox::FitInbox(int slots, int most)
    : slots_(slots),
      most_(static_cast<std::size_t>(most)),
      patience_(3 * most_),
      frames_(most_),
      since_shed_(patience_) {
  HDRCAM_CHECK(most_ >= two_cycles(slots));
}

int FitInbox::put(FrameShare frame) {
  int shed = 0;
  {
    const std::lock_guard lock(mutex_);
    ++since_caught_up_, ++since_shed_;
    for (; count_ >= room(); ++shed) shed_front(1);
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
  shed_front(chosen);
  drop_front(1);
  if (count_ == 0) since_caught_up_ = 0;
  last_slot_ = taken.frame->captured.raw.facts.slot;
  return taken;
}

bool FitInbox::waits() const { return since_shed_ >= patience_ && since_caught_up_ < patience_; }

std::size_t FitInbox::room() const { return waits() ? most_ : two_cycles(slots_); }

std::size_t FitInbox::next() const {
  if (last_slot_ < 0 || waits()) return 0;
  const int wanted = (last_slot_ + 1) % slots_;
  for (std::size_t i = count_; i-- > 0;)
    if (frames_[i]->captured.raw.facts.slot == wanted) return i;
  return 0;
}

void FitInbox::shed_front(std::size_t count) {
  if (count > 0) since_shed_ = 0;
  drop_front(count);
}

// Returns the frames to the pool and moves the others up.
void FitInbox::drop_front(std::size_t count) {
  std::move(frames_.begin() + static_cast<std::ptrdiff_t>(count),
            frames_.begin() + static_cast<std::ptrdiff_t>(count_), frames_.begin());
  for (std::size_t i = count_ - count; i < count_; ++i) frames_[i] = {};
  count_ -= count;
}

Backlog FitInbox::backlog() const {
  const std::lock_guard lock(mutex_);
  if (count_ > most_ / 2 || since_shed_ < most_ / 4) return Backlog::Pressing;
  if (since_caught_up_ > most_) return Backlog::Lasting;
  return count_ > 1 ? Backlog::Waiting : Backlog::None;
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
