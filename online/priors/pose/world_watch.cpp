#include "online/priors/pose/world_watch.h"

#include <utility>

namespace hdrcam {

void WorldWatch::begin(const ExposedFrame& frame) {
  cuts_.begin(frame);
  lost_ = 0;
}

// Pictures are compared across the frames that are lost, or black: the flow between two scenes may have
// points enough that agree with some pose.
bool WorldWatch::ends_before(const ExposedFrame& frame, const CameraPose& pose) {
  constexpr int kLongestLoss = 15;  // frames over which it is taken to have moved on as before
  if (pose.lost) {
    ++lost_;
    return false;
  }
  const bool cut = cuts_.ends_before(frame);
  return std::exchange(lost_, 0) > kLongestLoss || cut;
}

}  // namespace hdrcam
