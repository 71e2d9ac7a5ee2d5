// What one frame may cost: the knobs that may change from frame to frame, and what has no knob and is given
// up only to hold a deadline. It enters with each call, so that a governor can move along the front of
// quality against time without making anything anew. Plain value.
#pragma once

#include "online/priors/motion/motion_prior.h"
#include "online/scene/fit_budget.h"

namespace hdrcam {

// Of the tiles that the emitted picture is shrunk in: none, tiles that overlap by half, or twice as many.
enum class ShrinkageEffort { Off, On, Dense };

struct FrameBudget {
  FlowQuality flow = FlowQuality::Medium;
  FlowQuality flow_over_clipped = FlowQuality::Medium;  // no finer than that one
  FitBudget fit;
  bool fills = false;    // unseen pixels rise from the state's lower bound halfway to the field's radiance
  int render_step = 2;   // 1..8: they are filled, and depth is shown, from every n-th pixel of the field
  int later_frames = 2;  // of those that it waits for, so many join the emitted picture, the nearest first
  bool blurs = true;     // motion during the exposure is part of the match and of the state
  ShrinkageEffort shrinkage = ShrinkageEffort::Dense;  // of the emitted picture (render/shrinkage.h)
  // No pose, depth, fit or view of the field for this frame; the field starts anew when its rest ends.
  bool field_rests = false;
  bool emits = true;  // the frame that becomes ready; otherwise it only takes part in the state
};

}  // namespace hdrcam
