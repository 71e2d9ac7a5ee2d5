// The complete estimate of one frame, delivered as soon as its look-ahead has arrived. Const, and valid only
// during the call that delivers it; only the snapshot may be held longer.
#pragma once

#include "online/frame_budget.h"
#include "online/scene/scene_field.h"
#include "online/state/look_ahead.h"

namespace hdrcam {

struct FrameEstimate {
  const ExposedFrame& frame;
  const JoinedState& state;      // includes this frame and its look-ahead
  const FlowField* to_previous;  // null at the first frame
  SnapshotHold field;            // fitted up to this frame, inclusive; empty without a field
  SceneView view;                // the frame's own view, at full size
  const FitReport* fit;          // the fit's work on this frame; null without a field
  FrameBudget budget;            // the cost allowed for this frame
  float white;                   // radiance that saturates the shortest exposure so far
  double reference_exposure;     // E_ref, seconds x gains
};

}  // namespace hdrcam
