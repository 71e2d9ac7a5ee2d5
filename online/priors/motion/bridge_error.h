// How far the path over a clipped frame (clipped_motion_kernels.h) is off. It takes speed, or its change, for
// constant, and a hand that shakes keeps to neither. But where the frame is not clipped it shows its motion,
// too, and what moves alike around a clipped pixel is off alike. So the difference is summed up over cells of
// 8 pixels, and each cell gets the mean of what is near and moves as it does, as far as that is of one mind.
// Thread-bound.
#pragma once

#include <vector>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "online/priors/motion/clipped_motion_kernels.h"

namespace hdrcam {

class BridgeError {
 public:
  BridgeError(int rows, int cols);  // of the picture

  // path: over the frame; clipped, clipped_after: [1, rows, cols] share of the pixels around each that are
  // clipped in it and in the frame after; motion: [dx dy, rows, cols] from it to the state, as it shows it.
  void compare(const PathAhead& path, const Image<float>& clipped, const Image<float>& clipped_after,
               const Image<float>& motion, WorkerPool& pool);
  // [dx dy, cells down, cells across] pixels to be added to the path's motion to the state
  const Image<float>& cells() const { return off_; }

 private:
  const CheckedPathCell& cell(int down, int across) const {
    return sums_[static_cast<std::size_t>(down) * static_cast<std::size_t>(across_) +
                 static_cast<std::size_t>(across)];
  }
  CheckedPathCell told_around(int down, int across) const;
  void spread_to(int down, int across);

  int rows_, cols_, down_, across_;
  std::vector<CheckedPathCell> sums_;  // [cells down, cells across]
  Image<float> off_;
};

}  // namespace hdrcam
