// The second layer, in the order of a frame's way: pose, depth prior, window, then a fixed number of small
// steps of the fit. It starts from the state (online_stage.h) and answers what the state does not know.
// Thread-bound; deterministic whatever the number of threads.
#pragma once

#include <functional>
#include <memory>

#include "capture/exposed_frame.h"
#include "online/depth/multi_view_depth.h"
#include "online/fit/field_fit.h"
#include "online/motion/state_motion.h"
#include "online/pose/pose_source.h"

namespace hdrcam {

struct FieldStageOptions {
  FieldOptions field;
  PoseKind pose = PoseKind::Tracked;  // Given wins where the recording has poses
  DepthOptions depth;
};

// The fit's work on one frame.
struct FitReport {
  int steps = 0;
  LossValues<double> losses{};  // mean over the steps, weighted, by LossTerm
  long rolled_back = 0;         // of the steps, or skipped: the fit's health said no
};

class FieldStage {
 public:
  using Timing = std::function<void(const char* stage, double ms)>;

  // has_poses: frames carry T_world_camera
  FieldStage(const FieldStageOptions& options, const CameraFacts& camera, bool has_poses, WorkerPool& pool);

  // Takes the state at `frame`. motion: between the frame before and this one, null at the first.
  Result<FitReport> advance(const ExposedFrame& frame, const RadianceState& state, float white,
                            const StateMotion* motion, const Response& response, const Timing& timing);

  const RadianceField& field() const { return fit_.field(); }
  const FieldFit& fit() const { return fit_; }
  const CameraPose& pose() const { return *pose_; }  // of the newest frame

 private:
  void spread(const DepthPrior& depth);

  WorkerPool& pool_;
  std::unique_ptr<PoseSource> poses_;
  const CameraPose* pose_ = nullptr;
  MultiViewDepth depth_;
  float near_;  // in the poses' unit
  FieldFit fit_;
  Image<float> variance_, inverse_depth_;
  const FlowField none_{};
};

}  // namespace hdrcam
