#include "online/priors/pose/world_watch.h"

#include <algorithm>
#include <utility>

namespace hdrcam {
namespace {

SceneThumbnail small(const ExposedFrame& frame) {
  constexpr int kLines = 64;  // are enough, and a few tenths of a millisecond at 640x480
  return thumbnail_of(frame, std::max(1, frame.codes.rows() / kLines));
}

// A world that ends by mistake costs more than a cut that is missed: the limits are those of a sure one.
bool is_cut(const SceneThumbnail& before, const SceneThumbnail& after) {
  constexpr double kAlike = 0.3;                    // fast pans stay above .4, cuts are near 0
  constexpr std::size_t kQuarterOfThePicture = 64;  // in cells; steps of five stops have less in common
  return scene_agreement(before, after, kQuarterOfThePicture) < kAlike;
}

}  // namespace

void WorldWatch::begin(const ExposedFrame& frame) {
  seen_ = small(frame);
  lost_ = 0;
}

// Pictures are compared across the frames that are lost: the flow between two scenes may have points enough
// that agree with some pose.
bool WorldWatch::ends_before(const ExposedFrame& frame, const CameraPose& pose) {
  constexpr int kLongestLoss = 15;  // frames over which it is taken to have moved on as before
  if (pose.lost) {
    ++lost_;
    return false;
  }
  SceneThumbnail now = small(frame);
  const bool ends = std::exchange(lost_, 0) > kLongestLoss || is_cut(seen_, now);
  seen_ = std::move(now);
  return ends;
}

}  // namespace hdrcam
