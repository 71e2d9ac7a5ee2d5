// Joins later frames' samples to the state of a frame: they fill clipped or occluded pixels that are visible
// a moment later. The result is a copy that never feeds back, so the state stays causal. Thread-bound.
#pragma once

#include <cstddef>
#include <span>

#include "capture/exposed_frame.h"
#include "online/state/fusion.h"

namespace hdrcam {

// A later frame whose samples are joined.
struct LaterFrame {
  const ExposedFrame* frame;
  const FlowField* from_previous;  // from the previous frame
  const ExposureTables* tables;    // at its exposure
  bool shorter = false;            // exposed than the state's frame: what clips that, it need not clip
};

constexpr std::size_t kMaxLookAhead = 2;  // frames

// For how much of the time of the path to the last of these frames it was exposed: a part of the last
// interval, and intervals are not alike where a frame was lost.
inline float blur_of_path(std::span<const LaterFrame> path) {
  double time = 0;
  for (const LaterFrame& frame : path) time += frame.frame->interval_s;
  const ExposedFrame& last = *path.back().frame;
  const double part = time > 0 ? last.interval_s / time : 1 / static_cast<double>(path.size());
  return last.blur_fraction * static_cast<float>(part);
}

// What a state becomes with later frames.
struct JoinedState : RadianceEstimate {
  Image<float> later_share;  // [1, rows, cols] 0..1: how much of the estimate is later frames' samples
};

class LookAhead {
 public:
  explicit LookAhead(WorkerPool& pool) : pool_(pool) {}

  // later: the following frames, nearest first; one at least. unseen_variance: from which on a pixel of the
  // state counts as unseen.
  void join(const RadianceEstimate& state, std::span<const LaterFrame> later, float unseen_variance,
            Fusion& fusion, JoinedState& joined);

 private:
  const FlowField& lengthened(const FlowField& path, const FlowField& next);
  void take_samples(const LaterFrame& ahead, const Image<float>& path, Fusion& fusion);

  WorkerPool& pool_;
  // all borrowed during a call
  Samples samples_;
  FlowField path_;            // from the state's frame to a later frame than the next
  RadianceEstimate between_;  // of two later frames
  Image<float> share_, brightest_, gate_, contrast_, onward_, trust_;
};

}  // namespace hdrcam
