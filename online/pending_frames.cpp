#include "online/pending_frames.h"

#include <algorithm>
#include <utility>

#include "online/pictures/copy_in_parallel.h"

namespace hdrcam {
namespace {

// The bounds of a ratio, and what it is where time stamps stand still or run backward.
struct RatioRange {
  double otherwise, least, most;
};
constexpr RatioRange kOfIntervals{.otherwise = 1, .least = 0.1, .most = 10};
constexpr RatioRange kOfPart{.otherwise = 0.5, .least = 0.1, .most = 0.9};  // of an interval in two

float ratio(Duration interval, Duration other, const RatioRange& range) {
  if (interval <= Duration::zero() || other <= Duration::zero()) return static_cast<float>(range.otherwise);
  return static_cast<float>(std::clamp(to_seconds(interval) / to_seconds(other), range.least, range.most));
}

}  // namespace

PendingFrame& PendingFrames::add(ExposedFrame& frame) {
  if (spare_.empty()) {
    frames_.push_back(std::make_unique<PendingFrame>());
  } else {
    frames_.push_back(std::move(spare_.back()));
    spare_.pop_back();
  }
  PendingFrame& newest = *frames_.back();
  std::swap(newest.frame, frame);
  newest.advanced = newest.emitted = false;
  return newest;
}

void PendingFrames::retire_emitted() {
  while (frames_.size() > 1 && frames_.front()->emitted) retire_oldest();
}

void PendingFrames::retire_all() {
  while (!frames_.empty()) retire_oldest();
}

void PendingFrames::retire_oldest() {
  PendingFrame& oldest = *frames_.front();
  retired_times_ = {oldest.frame.facts.timestamp, retired_times_[0]};
  ++retired_;
  for (Image<float>* part : {&oldest.state.radiance, &oldest.state.variance, &oldest.state.own_share})
    pool_.scratch().release(*part);
  spare_.push_back(std::move(frames_.front()));
  frames_.erase(frames_.begin());
  if (!frames_.empty() && frames_.front()->advanced) return_motion_from_previous(0);
}

// The instant of the n-th frame before this one; n: one or two.
Instant PendingFrames::time_before(std::size_t place, std::size_t n) const {
  return place >= n ? frames_[place - n]->frame.facts.timestamp : retired_times_[n - place - 1];
}

float PendingFrames::before_ratio(std::size_t place) const {
  if (retired_ + place < 2) return 1;
  const Instant before = time_before(place, 1);
  return ratio(frames_[place]->frame.facts.timestamp - before, before - time_before(place, 2), kOfIntervals);
}

float PendingFrames::after_ratio(std::size_t place) const {
  const Instant before = time_before(place, 1);
  return ratio(frames_[place]->frame.facts.timestamp - before,
               frames_[place + 1]->frame.facts.timestamp - before, kOfPart);
}

void PendingFrames::borrow_motion_from_previous(std::size_t place) {
  PendingFrame& pending = *frames_[place];
  const Image<float>& codes = pending.frame.codes;
  FlowField& motion = pending.motion.from_previous;
  pool_.scratch().acquire(motion.vectors, 2, codes.rows(), codes.cols());
  pool_.scratch().acquire(motion.confidence, 1, codes.rows(), codes.cols());
}

void PendingFrames::return_motion_from_previous(std::size_t place) {
  FlowField& motion = frames_[place]->motion.from_previous;
  pool_.scratch().release(motion.vectors);
  pool_.scratch().release(motion.confidence);
}

void PendingFrames::keep_state(std::size_t place, const RadianceState& state) {
  PendingFrame& pending = *frames_[place];
  const auto keep = [this](const Image<float>& part, Image<float>& kept) {
    pool_.scratch().acquire(kept, part.channels(), part.rows(), part.cols());
    copy_in_parallel(part, kept, pool_);
  };
  keep(state.radiance, pending.state.radiance);
  keep(state.variance, pending.state.variance);
  keep(state.own_share, pending.state.own_share);
  if (!pending.scene) return;
  pending.depth.copy_from(*pending.scene->depth);
  pending.scene->depth = &pending.depth;
}

}  // namespace hdrcam
