// How pixels moved between the state and a new frame: the interface for another flow. Two passes: match()
// when the frame arrives, complete() before the state advances, when the next frame may be known. A flow
// whose rating is asked for has a confidence per pixel; where a frame shows none (clipped, black) an
// implementation may assume one with low confidence. Thread-bound; the result does not depend on the number
// of threads.
#pragma once

#include <memory>
#include <string>

#include "capture/exposed_frame.h"
#include "hal/core/worker_pool.h"
#include "hal/gpu/gpu_device.h"
#include "online/pictures/flow_field.h"
#include "online/state/exposure_tables.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

// Coarse finds the motion in pictures of a quarter of the size, Fast of half.
enum class FlowQuality { Coarse, Fast, Medium, Fine };

// How a step is matched. Ratios of intervals, here and below, are above 0; this one is (t_i - t_i-1) over
// (t_i-1 - t_i-2), 1 at the first step. The motion of the step before is what complete() left last.
struct MatchContext {
  FlowQuality flow = FlowQuality::Medium;
  bool blurs = true;  // the state is blurred as the frame was
  float before_ratio = 1;
};

// The steps before and after the interval that is completed; after_ratio: (t_i - t_i-1) over (t_i+1 - t_i-1).
struct MotionContext {
  float before_ratio = 1;
  const ExposedFrame* after = nullptr;  // the next frame; null without look-ahead
  const ExposureTables* after_tables = nullptr;
  float after_ratio = 0.5f;
};

// The flows whose confidence somebody reads; that of the others is left as it was.
struct RatedFlows {
  bool to_previous = true, from_previous = true;
};

class MotionPrior {
 public:
  virtual ~MotionPrior() = default;

  // state: at the previous frame. tables: at the frame's exposure.
  virtual void match(const RadianceState& state, const ExposedFrame& frame, const ExposureTables& tables,
                     const MatchContext& context, const RatedFlows& rated, StateMotion& motion) = 0;
  // Rates the motion to the previous frame in any case.
  virtual void complete(const RadianceState& state, const ExposedFrame& frame, const MotionContext& context,
                        FlowQuality quality, const RatedFlows& rated, StateMotion& motion) = 0;
  // Why it no longer runs where it was asked to; "" while it does.
  virtual std::string fallback_reason() const { return {}; }
};

// Optical flow (DIS) between the frame and the re-exposed state: motion_estimator.h. gpu: where the flow
// runs, null for the processor; it outlives the prior, as the pool does.
std::unique_ptr<MotionPrior> make_motion_prior(int rows, int cols, WorkerPool& pool, GpuDevice* gpu);

}  // namespace hdrcam
