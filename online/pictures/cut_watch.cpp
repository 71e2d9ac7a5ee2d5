#include "online/pictures/cut_watch.h"

#include <algorithm>

namespace hdrcam {
namespace {

constexpr std::size_t kQuarterOfThePicture = 64;  // in cells; steps of five stops have less in common

// A scene that ends by mistake costs more than a cut that is missed: the limits are those of a sure one.
bool is_cut(const SceneThumbnail& before, const SceneThumbnail& after) {
  constexpr double kAlike = 0.3;   // fast pans stay above .4, cuts are near 0
  constexpr double kPresumed = 3;  // codes: two dark pictures differ by noise
  return scene_agreement(before, after, kQuarterOfThePicture, kPresumed) < kAlike;
}

}  // namespace

SceneThumbnail CutWatch::small(const ExposedFrame& frame) {
  constexpr int kLines = 64;  // are enough, and below a millisecond at 640x480
  return thumbnail_of(frame, std::max(1, frame.codes.rows() / kLines), scratch_);
}

void CutWatch::begin(const ExposedFrame& frame) {
  seen_ = small(frame);
  age_ = 0;
}

bool CutWatch::ends_before(const ExposedFrame& frame) {
  const SceneThumbnail now = small(frame);
  const bool ends = is_cut(seen_, now);
  keep(now);
  return ends;
}

// A frame that shows little leaves the one before it for some time: later the camera may be elsewhere.
void CutWatch::keep(const SceneThumbnail& now) {
  constexpr int kOldest = 8;  // frames: two rounds of a long cycle
  if (!shows_scene(now, kQuarterOfThePicture) && ++age_ <= kOldest) return;
  seen_ = now;
  age_ = 0;
}

}  // namespace hdrcam
