#include "online/second_layer.h"

#include <algorithm>

namespace hdrcam {

SecondLayer::SecondLayer(const Knobs& knobs, const CameraFacts& camera, WorkerPool& pool, GpuDevice* gpu)
    : knobs_(knobs),
      camera_(camera),
      lens_(camera.intrinsics ? *camera.intrinsics : assumed_intrinsics(camera.height, camera.width)),
      field_step_px_(hdrcam::field_step_px(knobs.field_step, camera.height, camera.width)),
      pool_(pool),
      gpu_(gpu) {}

Result<SceneEstimate> SecondLayer::take(const SeenFrame& seen, float unseen_variance,
                                        const Response& response, const FitBudget& budget) {
  StageWatch watch(timing_);
  field_before_ = {};
  const StateMotion none;  // where the frame before is of another world, or was not taken
  const CameraPose* known = field_ && !rested_ ? pose_in_this_world(seen) : nullptr;
  const bool begins = known == nullptr;
  if (begins) begin(seen.frame);
  leaves_out_poses_ |= knobs_.pose == PoseKind::Given && !has_poses_ && seen.frame.facts.T_world_camera;
  const SeenFrame input{seen.frame, seen.state, begins ? none : seen.motion};
  const CameraPose& pose = begins ? poses_->estimate(input) : *known;
  const DepthMap& depth = depth_->estimate(input, pose);
  watch.lap(Stage::Pose);
  TRY(field_->observe({input.frame, input.state, unseen_variance, input.motion, pose, depth, response}));
  const FitReport fit = field_->fit(budget);
  watch.lap(Stage::Fit);
  return SceneEstimate{pose.T_world_camera, world_, stated_pose(seen.frame, pose), &depth, fit};
}

FieldNow SecondLayer::field_of(int world) {
  if (world == world_) return FieldNow(field_.get());
  return world + 1 == world_ ? FieldNow(field_before_) : FieldNow();
}

// Null where another world begins with the frame; frames before it that wait then keep the field of this one.
const CameraPose* SecondLayer::pose_in_this_world(const SeenFrame& seen) {
  const CameraPose& pose = poses_->estimate(seen);
  const bool ends = poses_->source() == PoseSource::Tracked && watch_.ends_before(pose);
  if (ends) field_before_ = field_->snapshot();
  return ends ? nullptr : &pose;
}

void SecondLayer::begin(const ExposedFrame& first) {
  rested_ = false;
  ++world_;
  watch_.begin();
  const bool first_world = field_ == nullptr;
  if (first_world)
    has_poses_ = first.facts.T_world_camera.has_value();  // a unit of length for all of the run
  poses_ = make_pose_prior(knobs_.pose, camera_, has_poses_, pool_);
  if (first_world && poses_->source() == PoseSource::Tracked && !camera_.intrinsics)
    warn_of_assumed_lens(camera_);
  DepthOptions depth = knobs_.depth;
  // no finer than the field's blocks can use, and half as fine where nobody looks at it
  const bool seen = knobs_.field_step != FieldStep::Auto;
  depth.step_px = std::max(depth.step_px, seen ? field_step_px_ / 2 : 2 * field_step_px_);
  depth_ = std::make_unique<DynamicDepth>(depth, knobs_.dynamic_depth, lens_, camera_.height, camera_.width,
                                          pool_);
  if (field_) return field_->restart();
  FieldOptions options = knobs_.hash_grid;
  options.step_px = field_step_px_;
  field_ = make_scene_field(knobs_.field, options,
                            {lens_, camera_.height, camera_.width, poses_->near(), gpu_}, pool_);
}

std::optional<FramePose> SecondLayer::stated_pose(const ExposedFrame& frame, const CameraPose& pose) const {
  if (poses_->source() == PoseSource::Given) return given_pose(frame.facts);
  return FramePose{pose.T_world_camera, poses_->source(), pose.lost, world_};
}

std::optional<FramePose> SecondLayer::given_pose(const FrameFacts& facts) const {
  if (knobs_.pose != PoseKind::Given || !facts.T_world_camera) return std::nullopt;
  if (poses_ && poses_->source() != PoseSource::Given) return std::nullopt;  // it is of another world
  const RigidTransform T_world_camera = transform_of(*facts.T_world_camera);
  if (!T_world_camera.finite()) return std::nullopt;
  return FramePose{.T_world_camera = T_world_camera, .source = PoseSource::Given};
}

}  // namespace hdrcam
