// Tells when a tracked camera is in a world of its own: found again after it was lost for so long that nobody
// knows how it moved. Its poses and its depth then have nothing to do with those before. At a cut all begins
// anew (pictures/cut_watch.h). Thread-bound.
#pragma once

#include "online/priors/pose/pose_prior.h"

namespace hdrcam {

class WorldWatch {
 public:
  // With the first frame of a world.
  void begin() { lost_ = 0; }
  // A later one, with the pose that was tracked from the frames before it: whether another world begins.
  bool ends_before(const CameraPose& pose);

 private:
  int lost_ = 0;  // frames in a row
};

}  // namespace hdrcam
