// The interface of a field: a model of the scene that gives radiance where no frame saw a pixel, for any view
// and time of its window. Each frame is added (observe), fitted within a budget (fit), and read through
// immutable snapshots. An implementation has a folder beside this file and a line in scene_fields.h.
// Thread-bound except for the snapshots; the same frames, budgets and seed give the same bytes for any number
// of threads.
#pragma once

#include <string>

#include "capture/exposed_frame.h"
#include "hal/core/inline_list.h"
#include "hal/core/result.h"
#include "hal/gpu/gpu_device.h"
#include "online/pictures/flow_field.h"
#include "online/priors/depth/depth_prior.h"
#include "online/priors/pose/pose_prior.h"
#include "online/response/response.h"
#include "online/scene/field_snapshot.h"
#include "online/scene/fit_budget.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

// Settings of every field, fixed at the start.
struct SceneSetup {
  Intrinsics lens;
  int rows = 0, cols = 0;
  float near = 1;            // distance of the near plane, in the poses' unit
  GpuDevice* gpu = nullptr;  // fits and renders the field; null for the processor; outlives the field
};

// The facts and estimates of one frame for observe(); borrowed for the call.
struct SceneObservation {
  const ExposedFrame& frame;
  const RadianceState& state;  // includes this frame
  float unseen_variance;       // from which on a pixel counts as unseen
  const StateMotion& motion;   // between the previous frame and this one; empty at the first
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
  long rolled_back = 0;         // steps rolled back or skipped by the fit's health check
  InlineList<Loss, 24> losses;  // the nonzero ones
};

class SceneField {
 public:
  virtual ~SceneField() = default;

  // Errors: Invalid, BadExposure for an impossible frame; the field is then unchanged.
  virtual Result<void> observe(const SceneObservation& seen) = 0;
  // Needs a frame. Without any steps the field can still be rendered: it shows at least the state.
  virtual FitReport fit(const FitBudget& budget) = 0;
  // Forgets all frames and what was fitted to them: the next frame is a first one. Snapshots stay as they
  // are.
  virtual void restart() = 0;
  // A snapshot of the field now. Needs a frame.
  virtual SnapshotHold snapshot() = 0;
  // Why the fit no longer runs on the graphics device that it was given; "" while it does, or has none.
  virtual std::string fallback_reason() const { return {}; }
};

// A field as it is now, for whoever may read it, or none. A snapshot copies the networks, and while it is
// held each frame that is observed costs one more copy; so it is taken when somebody first asks. Thread-bound
// as the field, and valid until its next change.
class FieldNow {
 public:
  FieldNow() = default;
  explicit FieldNow(SceneField* field) : field_(field) {}
  explicit FieldNow(SnapshotHold taken) : taken_(std::move(taken)) {}

  explicit operator bool() const { return field_ != nullptr || taken_; }
  const SnapshotHold& operator->() const { return snapshot(); }
  const SnapshotHold& snapshot() const {
    if (field_ != nullptr && !taken_) taken_ = field_->snapshot();
    return taken_;
  }

 private:
  SceneField* field_ = nullptr;
  mutable SnapshotHold taken_;
};

}  // namespace hdrcam
