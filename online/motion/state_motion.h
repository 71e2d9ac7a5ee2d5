// Motion between a new frame and the state: the state is re-exposed to the frame's exposure, so that both
// pictures look alike whatever the schedule, and matched both ways. Where the frame is clipped it shows no
// motion; there the motion goes on as before, or is taken from the frame after next, if that one is not
// clipped too. Thread-bound.
#pragma once

#include "capture/exposed_frame.h"
#include "online/motion/dense_flow.h"
#include "online/motion/flow_field.h"
#include "online/state/exposure_tables.h"
#include "online/state/fusion.h"

namespace hdrcam {

// Flow between the state at frame i-1 and frame i.
struct StateMotion {
  FlowField to_previous;    // frame -> state
  FlowField from_previous;  // state -> frame
};

class MotionEstimator {
 public:
  MotionEstimator(FlowQuality quality, int rows, int cols, WorkerPool& pool);

  // First look: both flows as matched, with their confidence.
  void match(const RadianceState& state, const ExposedFrame& frame, const ExposureTables& tables,
             StateMotion& motion);

  // Second look, before the state advances to `frame`: completes motion where the frame is clipped, from
  // `before`, the motion of the previous step (null at the first), and from the frame after it (null without
  // look-ahead). interval ratios: (t_i - t_i-1) over (t_i-1 - t_i-2), and over (t_i+1 - t_i-1).
  void complete(const RadianceState& state, const ExposedFrame& frame, const StateMotion* before,
                float before_ratio, const ExposedFrame* after, const ExposureTables* after_tables,
                float after_ratio, StateMotion& motion);

 private:
  void bridge(float r, StateMotion& motion);
  void clipped_share(const ExposedFrame& frame, Image<float>& share);
  void rate(const ExposedFrame* frame, StateMotion& motion);

  int rows_, cols_;
  WorkerPool& pool_;
  DenseFlow flow_;
  Image<std::uint8_t> frame_gray_, state_gray_;
  Image<float> mask_, clipped_, clipped_after_, warped_, after_to_state_, state_to_after_;
  Image<float> bridged_, ahead_, seen_from_after_, seen_from_state_, clipped_seen_;
};

}  // namespace hdrcam
