// For how many frames something that turned out too slow is not tried again. The first wait takes four
// seconds, each further one twice as long as the one before, up to sixteen times the first. A machine that
// became faster since the wait began is a reason not to wait. Thread-bound.
#pragma once

#include "hal/core/instant.h"

namespace hdrcam {

class Backoff {
 public:
  // frame: the time between two frames. Over at first.
  explicit Backoff(Duration frame);

  // steady_ms, here and below: what the machine takes for the same work (FrameTime), at present.
  void begin(double steady_ms);
  // One frame passes. Whether the wait is over with it.
  bool pass();
  bool is_over() const { return frames_left_ == 0; }
  bool is_machine_faster(double steady_ms) const;

  // The next wait takes four seconds again; a wait that has begun goes on.
  void shorten_next() { next_ = first_; }
  // The wait is over, too.
  void reset();

 private:
  const int first_;  // frames, as below
  int next_;
  int frames_left_ = 0;
  double steady_ms_ = 0;  // when it began
};

}  // namespace hdrcam
