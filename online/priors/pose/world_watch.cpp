#include "online/priors/pose/world_watch.h"

#include <algorithm>
#include <utility>

namespace hdrcam {
namespace {

constexpr std::size_t kQuarterOfThePicture = 64;  // in cells; steps of five stops have less in common

// A world that ends by mistake costs more than a cut that is missed: the limits are those of a sure one.
bool is_cut(const SceneThumbnail& before, const SceneThumbnail& after) {
  constexpr double kAlike = 0.3;   // fast pans stay above .4, cuts are near 0
  constexpr double kPresumed = 3;  // codes: two dark pictures differ by noise
  return scene_agreement(before, after, kQuarterOfThePicture, kPresumed) < kAlike;
}

}  // namespace

SceneThumbnail WorldWatch::small(const ExposedFrame& frame) {
  constexpr int kLines = 64;  // are enough, and below a millisecond at 640x480
  return thumbnail_of(frame, std::max(1, frame.codes.rows() / kLines), scratch_);
}

void WorldWatch::begin(const ExposedFrame& frame) {
  seen_ = small(frame);
  age_ = lost_ = 0;
}

// Pictures are compared across the frames that are lost, or black: the flow between two scenes may have
// points enough that agree with some pose.
bool WorldWatch::ends_before(const ExposedFrame& frame, const CameraPose& pose) {
  constexpr int kLongestLoss = 15;  // frames over which it is taken to have moved on as before
  if (pose.lost) {
    ++lost_;
    return false;
  }
  const SceneThumbnail now = small(frame);
  const bool ends = std::exchange(lost_, 0) > kLongestLoss || is_cut(seen_, now);
  keep(now);
  return ends;
}

// A frame that shows little leaves the one before it for some time: later the camera may be elsewhere.
void WorldWatch::keep(const SceneThumbnail& now) {
  constexpr int kOldest = 8;  // frames: two rounds of a long cycle
  if (!shows_scene(now, kQuarterOfThePicture) && ++age_ <= kOldest) return;
  seen_ = now;
  age_ = 0;
}

}  // namespace hdrcam
