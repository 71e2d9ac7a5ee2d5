// The queue of frames for the fit. When it is full the oldest frame is shed; it has one of two bounds:
//   most              while the fit is late for a moment, at its start or because the machine did something
//                     else: until three times as many frames have come since it had caught up
//   two cycles and 1  when it has not caught up by then, and so is slower than the camera: until nothing was
//                     shed for those three times as many frames
// Under the second bound frames are shed in whole cycles: the fit gets the newest frame of the slot that
// follows its last one, and everything older is shed. So it gets runs of neighbouring frames, exposures
// always alternate, and no frame is older than one cycle plus the fit's own work on one frame. To skip single
// frames would starve a slot: a fit at half the speed of a camera with two exposures would get only one of
// them. A frame outside the schedule (slot -1) is taken only as the oldest. Thread-safe.
#pragma once

#include <condition_variable>
#include <mutex>
#include <vector>

#include "firmware_host/live/frame_pool.h"
#include "firmware_host/run/backlog.h"

namespace hdrcam {

class FitInbox {
 public:
  // most: frames that may wait, at least two cycles and one frame.
  FitInbox(int slots, int most);

  // Never waits. Returns the number of frames shed for it.
  int put(FrameShare frame);

  struct Taken {
    FrameShare frame;  // empty after the timeout, and at the end
    int shed = 0;      // frames shed before this one
  };
  Taken take(Duration timeout);

  // Lasting: it has not caught up for as many frames as may wait.
  Backlog backlog() const;
  // No more frames follow.
  void close();
  bool ended() const;  // closed and empty

 private:
  bool waits() const;
  std::size_t room() const;  // frames
  std::size_t next() const;  // index of the frame that the fit gets next
  void shed_front(std::size_t count);
  void drop_front(std::size_t count);

  const int slots_;
  const std::size_t most_, patience_;  // frames
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<FrameShare> frames_;  // oldest first; the first count_ of them
  std::size_t count_ = 0;
  std::size_t since_caught_up_ = 0, since_shed_;  // frames that came
  int last_slot_ = -1;
  bool closed_ = false;
};

}  // namespace hdrcam
