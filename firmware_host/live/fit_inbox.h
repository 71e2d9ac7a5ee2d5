// The queue of frames for the fit, and the shedding when the fit is slower than the camera. Skipping single
// frames would starve a slot of the cycle: a fit at half the speed of a camera with two exposures would get
// only one of them. So frames are shed in whole cycles: the fit gets the newest frame of the slot that
// follows its last one, and everything older is shed. It gets runs of neighbouring frames, exposures always
// alternate, and no frame is older than one cycle plus the fit's own work on one frame. A frame outside the
// schedule (slot -1) is taken only as the oldest. Bounded: two cycles; when full, the oldest frame is shed.
// Thread-safe.
#pragma once

#include <array>
#include <condition_variable>
#include <mutex>

#include "firmware_host/live/frame_pool.h"

namespace hdrcam {

class FitInbox {
 public:
  explicit FitInbox(int slots) : slots_(slots), capacity_(static_cast<std::size_t>(2 * slots + 1)) {}

  // Never waits. Returns the number of frames shed for it.
  int put(FrameShare frame);

  struct Taken {
    FrameShare frame;  // empty after the timeout, and at the end
    int shed = 0;      // frames shed before this one
  };
  Taken take(Duration timeout);

  // No more frames follow.
  void close();
  bool ended() const;  // closed and empty

 private:
  static constexpr std::size_t kMost = 2 * ExposureSchedule::kMaxSlots + 1;

  std::size_t next() const;  // index of the frame that the fit gets next
  void drop_front(std::size_t count);

  const int slots_;
  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::array<FrameShare, kMost> frames_;  // oldest first
  std::size_t count_ = 0;
  int last_slot_ = -1;
  bool closed_ = false;
};

}  // namespace hdrcam
