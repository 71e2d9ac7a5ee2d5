#include "online/priors/pose/world_watch.h"

#include <utility>

namespace hdrcam {

bool WorldWatch::ends_before(const CameraPose& pose) {
  constexpr int kLongestLoss = 15;  // frames over which it is taken to have moved on as before
  if (pose.lost) {
    ++lost_;
    return false;
  }
  return std::exchange(lost_, 0) > kLongestLoss;
}

}  // namespace hdrcam
