// The seam of the field: what stands behind the state and answers where nobody saw a pixel, for any view and
// time of its window. It is told of each frame (observe), given a budget to learn from it (fit), and read
// through immutable snapshots. An implementation has a folder beside this file and a line in scene_fields.h.
// Thread-bound but for the snapshots; the same frames, budgets and seed give the same bytes for any number of
// threads.
#pragma once

#include "capture/exposed_frame.h"
#include "hal/core/inline_list.h"
#include "hal/core/result.h"
#include "online/pictures/flow_field.h"
#include "online/priors/depth/depth_prior.h"
#include "online/priors/pose/pose_prior.h"
#include "online/response/response.h"
#include "online/scene/field_snapshot.h"
#include "online/scene/fit_budget.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

// What is known about one frame when the field is told of it; borrowed for the call.
struct SceneObservation {
  const ExposedFrame& frame;
  const RadianceState& state;  // up to and with this frame
  float white;                 // radiance that saturates the shortest exposure so far
  const StateMotion& motion;   // between the frame before and this one; empty at the first
  const CameraPose& pose;
  const DepthMap& depth;  // may be empty
  const Response& response;
};

// The fit's work on one frame.
struct FitReport {
  struct Loss {
    const char* name = "";
    double value = 0;  // weighted, mean over the steps taken
  };
  int steps = 0;
  long rolled_back = 0;         // of the steps, or skipped: the fit's health said no
  InlineList<Loss, 24> losses;  // those that are not zero
};

class SceneField {
 public:
  virtual ~SceneField() = default;

  // Errors: Invalid, BadExposure for a frame that cannot be; the field is unchanged then.
  virtual Result<void> observe(const SceneObservation& seen) = 0;
  // Needs a frame. Zero steps leave something that can be looked at: at least what the state knows.
  virtual FitReport fit(const FitBudget& budget) = 0;
  // The field as it is now. Needs a frame.
  virtual SnapshotHold snapshot() = 0;
};

}  // namespace hdrcam
