// A fixed number of captured frames, shared between the recorder and the fit without a copy. It alone bounds
// the memory of a live run: when all frames are held, the newest frame is dropped, counted, and flagged on
// the next one. All are allocated at the start, so that a fit that is late for a moment costs no allocation.
// The frame returned last is reused first, so that a run that keeps up touches little of that memory for any
// size of the pool. Thread-safe; the pool outlives its frames.
#pragma once

#include <atomic>
#include <mutex>
#include <utility>
#include <vector>

#include "capture/captured_frame.h"

namespace hdrcam {

class FramePool {
 public:
  struct Slot {
    CapturedFrame captured;
    Instant arrived;  // when capture delivered it

   private:
    friend class FramePool;
    FramePool* pool_ = nullptr;
    std::atomic<int> holders_{0};
  };

  // One holder's share of a frame; the frame is free again when the last share is released.
  class Share {
   public:
    Share() = default;
    Share(Share&& other) noexcept : slot_(std::exchange(other.slot_, nullptr)) {}
    Share& operator=(Share&& other) noexcept { return std::swap(slot_, other.slot_), *this; }
    ~Share() {
      if (slot_ != nullptr) release(*slot_);
    }
    Share another() const {
      if (slot_ != nullptr) slot_->holders_.fetch_add(1, std::memory_order_relaxed);
      return Share(slot_);
    }
    explicit operator bool() const { return slot_ != nullptr; }
    Slot& operator*() const { return *slot_; }
    Slot* operator->() const { return slot_; }

   private:
    friend class FramePool;
    explicit Share(Slot* slot) : slot_(slot) {}
    Slot* slot_ = nullptr;
  };

  // camera: whose pictures the frames hold.
  explicit FramePool(int frames, const CameraFacts& camera = {}) : slots_(static_cast<std::size_t>(frames)) {
    free_.reserve(slots_.size());
    for (std::size_t i = slots_.size(); i-- > 0;) {
      slots_[i].captured.raw.codes.reshape(channels(camera.layout), camera.height, camera.width);
      slots_[i].pool_ = this, free_.push_back(&slots_[i]);
    }
  }

  int size() const { return static_cast<int>(slots_.size()); }

  // Empty when every frame is held.
  Share take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return {};
    Slot* slot = free_.back();
    free_.pop_back();
    slot->holders_.store(1, std::memory_order_relaxed);
    return Share(slot);
  }

 private:
  static void release(Slot& slot) {
    if (slot.holders_.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
    const std::lock_guard lock(slot.pool_->mutex_);
    slot.pool_->free_.push_back(&slot);
  }

  std::vector<Slot> slots_;
  std::mutex mutex_;
  std::vector<Slot*> free_;
};

using FrameShare = FramePool::Share;

}  // namespace hdrcam
