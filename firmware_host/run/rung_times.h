// The times of the newest frames on one rung of the ladder (budget_ladder.h), and what a frame takes by them.
// Frames of a cycle are uneven: those whose long exposure is clipped take half as long again. Where frames
// queue, the queue evens that out and their mean counts; elsewhere each has to be in time, and their upper
// quartile counts. No allocation. Thread-bound.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "firmware_host/run/frame_work.h"

namespace hdrcam {

// Of one frame; where a rung emits only some frames, the mean of the frames of one emission.
struct FrameTime {
  double total_ms = 0, steady_ms = 0;
  double ratio() const { return total_ms / steady_ms; }  // free of the speed of the machine
};

class RungTimes {
 public:
  static constexpr std::size_t kWindow = 8;  // frame times kept

  // Call it before the frame times are asked for.
  void set_frames_queue(bool frames_queue) { frames_queue_ = frames_queue; }

  // Adds one frame of `of` with one emission. Returns their mean with the last of them.
  std::optional<FrameTime> add(const FrameWork& work, int of);
  // Another rung is in use from the next frame on.
  void restart();

  std::size_t count() const { return count_; }  // of frame times, since the rung changed
  bool is_full() const { return count_ >= kWindow; }

  // Of the `newest` frame times, as many at most as there are. Two outliers of eight do not count.
  FrameTime upper_quartile(std::size_t newest) const;
  // Of the window, in which the longest frame, perhaps an outlier, counts as the second longest. count() > 1.
  FrameTime mean() const;
  // What a frame takes: the mean where frames queue, else the upper quartile of the window.
  FrameTime usual() const;
  // The speed of the machine: what its steady work takes.
  double steady_ms() const;
  // What a frame takes in units of the steady work.
  double ratio() const;

 private:
  // How many frame times the window has.
  std::size_t kept() const;

  bool frames_queue_ = false;
  std::array<FrameTime, kWindow> window_{};  // a ring
  std::size_t count_ = 0;
  int unsettled_ = 0;  // frame times after a change that do not count
  FrameTime pending_;  // the sum of the frames of an emission that is not complete
  int pending_frames_ = 0;
};

}  // namespace hdrcam
