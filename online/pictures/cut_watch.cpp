#include "online/pictures/cut_watch.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr std::size_t kQuarterOfThePicture = 64;  // in cells; steps of five stops have less in common

// A scene that ends by mistake costs more than a cut that is missed: the limits are those of a sure one.
bool show_two_scenes(const SceneThumbnail& before, const SceneThumbnail& after) {
  constexpr double kAlike = 0.3;   // fast pans stay above .4, cuts are near 0
  constexpr double kPresumed = 3;  // codes: two dark pictures differ by noise
  return scene_agreement(before, after, kQuarterOfThePicture, kPresumed) < kAlike;
}

}  // namespace

void CutWatch::begin(const ExposedFrame& frame) {
  begin({frame.exposure, quick_thumbnail_of(frame, scratch_)});
}

void CutWatch::begin(const Seen& first) {
  telling_ = first;
  age_ = 0;
  count_ = 0;
  if (shows_scene(first.thumbnail, kQuarterOfThePicture)) recent_[count_++] = first;
}

bool CutWatch::ends_before(const ExposedFrame& frame) {
  const Seen now{frame.exposure, quick_thumbnail_of(frame, scratch_)};
  const Seen* alike = newest_of(now.exposure);
  const bool ends = show_two_scenes(telling_.thumbnail, now.thumbnail) &&
                    (alike == nullptr || show_two_scenes(alike->thumbnail, now.thumbnail));
  ends ? begin(now) : keep(now);
  return ends;
}

const CutWatch::Seen* CutWatch::newest_of(float exposure) const {
  constexpr float kAlike = 0.25f;  // ln: what is left of jitter, less than any step of a cycle
  for (std::size_t i = count_; i > 0 && i + recent_.size() > count_; --i) {
    const Seen& before = recent_[(i - 1) % recent_.size()];
    if (std::abs(std::log(before.exposure / exposure)) < kAlike) return &before;
  }
  return nullptr;
}

// A frame that shows little leaves the one before it for some time: later the camera may be elsewhere.
void CutWatch::keep(const Seen& now) {
  const bool shows = shows_scene(now.thumbnail, kQuarterOfThePicture);
  if (shows) recent_[count_++ % recent_.size()] = now;
  if (!shows && ++age_ <= kTwoRounds) return;
  telling_ = now;
  age_ = 0;
}

}  // namespace hdrcam
