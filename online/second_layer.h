// The second layer of the method, above the state: where a frame was seen from, how deep its scene is, and
// the field that is fitted to both (docs/architecture.md, "Two layers"). It is made with the first frame that
// it takes and may rest, as it does at a cut: after that, or a long loss of a tracked pose, pose, depth and
// field begin anew, in another world, because what they knew is of another time or place. World, axes and
// unit of length: priors/pose/frame_pose.h. Thread-bound but for snapshots of the field, which it owns; the
// result does not depend on the number of threads.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "hal/core/stage_timing.h"
#include "online/knobs.h"
#include "online/priors/depth/depth_prior.h"
#include "online/priors/pose/pose_prior.h"
#include "online/priors/pose/world_watch.h"
#include "online/scene/scene_fields.h"

namespace hdrcam {

// What the second layer says of one frame.
struct SceneEstimate {
  RigidTransform T_world_camera;    // in the world of the field
  int world = 0;                    // counts the beginnings of pose, depth and field
  std::optional<FramePose> pose;    // as outputs state it: a given one keeps the recording's own numbers
  const DepthMap* depth = nullptr;  // the layer's own: valid until it takes the next frame
  FitReport fit;
};

class SecondLayer {
 public:
  // pool: of the thread that owns the layer. gpu: fits and renders the field; null for the processor. Both
  // outlive the layer.
  SecondLayer(const Knobs& knobs, const CameraFacts& camera, WorkerPool& pool, GpuDevice* gpu);

  // --- each frame, in the order of the stream: one of the two ---
  // Takes the frame into pose, depth and field, and fits the field within the budget. seen.motion: not read
  // at the first frame and after a rest. unseen_variance: from which on a pixel of the state counts as
  // unseen. Needs a field (FieldKind). Errors: those of SceneField::observe.
  Result<SceneEstimate> take(const SeenFrame& seen, float unseen_variance, const Response& response,
                             const FitBudget& budget);
  // The layer has no part in the frame, and begins anew with the next one that it takes.
  void rest() { rested_ = true; }

  // --- what is known ---
  // The pose that the recording states, also of a frame that is not taken; none where it states none that can
  // be, or is not asked, or where poses are tracked because the first frame stated none.
  std::optional<FramePose> given_pose(const FrameFacts& facts) const;
  // Whether a frame stated a pose that had no part, because the first frame stated none.
  bool leaves_out_given_poses() const { return leaves_out_poses_; }
  // Of this world, fitted up to the frame that was taken last; empty before the first one. Where another
  // world began with that frame, the field of the one before it is there until the next is taken.
  FieldNow field_of(int world);
  // One unit of the field's depth (FieldPicture::depth), in length_unit().
  float depth_unit() const { return poses_ ? poses_->near() : 1; }
  LengthUnit length_unit() const { return poses_ ? unit_of(poses_->source()) : LengthUnit::Metre; }
  const Intrinsics& lens() const { return lens_; }      // assumed where the camera does not report it
  int field_step_px() const { return field_step_px_; }  // side of the blocks that are the field's pixels
  // Why the fit no longer runs on the graphics device; "" while it does, or was not asked to.
  std::string fallback_reason() const { return field_ ? field_->fallback_reason() : std::string(); }

  void set_timing(StageTiming timing) { timing_ = std::move(timing); }

 private:
  const CameraPose* pose_in_this_world(const SeenFrame& seen);
  void begin(const ExposedFrame& first);
  std::optional<FramePose> stated_pose(const ExposedFrame& frame, const CameraPose& pose) const;

  const Knobs knobs_;
  const CameraFacts camera_;
  const Intrinsics lens_;
  const int field_step_px_;
  WorkerPool& pool_;
  GpuDevice* const gpu_;

  bool has_poses_ = false;  // the recording states poses: its first frame here does
  bool leaves_out_poses_ = false;
  int world_ = -1;       // of the poses: counts their beginnings
  bool rested_ = false;  // since its last frame
  std::unique_ptr<PosePrior> poses_;
  WorldWatch watch_;  // of tracked poses
  std::unique_ptr<DepthPrior> depth_;
  std::unique_ptr<SceneField> field_;
  SnapshotHold field_before_;  // as it was when its world ended with the newest frame
  StageTiming timing_;
};

}  // namespace hdrcam
