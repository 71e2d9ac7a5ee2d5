// Tells when a tracked camera is in a world of its own: behind a cut, or found again after it was lost for so
// long that nobody knows how it moved. Its poses and its depth then have nothing to do with those before. No
// allocation after the first frame. Thread-bound.
#pragma once

#include "online/pictures/cut_watch.h"
#include "online/priors/pose/pose_prior.h"

namespace hdrcam {

class WorldWatch {
 public:
  // The first frame of a world.
  void begin(const ExposedFrame& frame);
  // A later one, with the pose that was tracked from the frames before it: whether another world begins.
  bool ends_before(const ExposedFrame& frame, const CameraPose& pose);

 private:
  CutWatch cuts_;
  int lost_ = 0;  // frames in a row
};

}  // namespace hdrcam
