#include "online/online_stage.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/clip_policy.h"
#include "hal/core/stopwatch.h"
#include "online/pictures/for_samples.h"

namespace hdrcam {
namespace {

constexpr std::size_t kMaxLookAhead = 2;  // frames

// As the recording states it; none where it states none that can be.
std::optional<FramePose> given_pose(const FrameFacts& facts) {
  if (!facts.T_world_camera) return std::nullopt;
  const RigidTransform T_world_camera = from_matrix(*facts.T_world_camera);
  if (!T_world_camera.finite()) return std::nullopt;
  return FramePose{.T_world_camera = T_world_camera, .source = PoseSource::Given};
}

// Of intervals between time stamps, which may be wrong.
float ratio(Duration interval, Duration other) {
  if (interval <= Duration::zero() || other <= Duration::zero()) return 1;
  return static_cast<float>(std::clamp(to_seconds(interval) / to_seconds(other), 0.1, 10.0));
}

}  // namespace

struct OnlineStage::Step {
  ExposedFrame frame;
  float stated_blur = 0;  // share of its motion that blurs it by its facts
  StateMotion motion;     // between the state at the frame before and this one
  // After this frame, where a later one has taken its place before this one was emitted; borrowed.
  RadianceState state;
  DepthMap depth;
  RigidTransform T_world_camera;
  std::optional<FramePose> pose;  // of a frame in the field
  FitReport fit;
  bool advanced = false, emitted = false;
  bool in_field = false;
};

OnlineStage::OnlineStage(const Knobs& knobs, const CameraFacts& camera,
                         const std::optional<Response>& response, WorkerPool& pool, GpuDevice* gpu)
    : knobs_(knobs),
      budget_(knobs.budget),
      camera_(camera),
      look_ahead_(look_ahead_of(knobs, camera.height, camera.width)),
      field_step_(field_step_px(knobs.field_step, camera.height, camera.width)),
      lens_(camera.intrinsics ? *camera.intrinsics : assumed_intrinsics(camera.height, camera.width)),
      pool_(pool),
      gpu_(gpu),
      motion_(make_motion_prior(camera.height, camera.width, pool)),
      state_(make_state_layer(knobs.state, camera.height, camera.width, pool, gpu)),
      sensor_(knobs, camera, response, *state_, pool) {}

OnlineStage::~OnlineStage() = default;

Result<void> OnlineStage::ingest(ExposedFrame& frame, const FrameBudget& budget, const Emit& emit) {
  budget_ = budget;
  budget_.render_step = std::max(budget.render_step, field_step_);  // nothing more between the field's pixels
  sensor_.meet(frame);
  if (!sensor_.is_known()) {
    waiting_.emplace_back(frame, camera_.bits);
    return static_cast<int>(waiting_.size()) < knobs_.bootstrap_frames ? Result<void>() : bootstrap(emit);
  }
  Stopwatch watch;
  if (const auto found = sensor_.learn_response(frame)) TRY(begin_anew(*found, frame.index, emit));
  sensor_.correct(frame);
  if (timing_) timing_(Stage::Unpack, watch.lap_ms());
  return take(frame, emit);
}

// Response and black level from the first frames, which then take their way.
Result<void> OnlineStage::bootstrap(const Emit& emit) {
  sensor_.learn_first(waiting_);
  ExposedFrame frame;
  for (CompactFrame& waiting : waiting_) {
    waiting.restore(frame);
    waiting = {};
    sensor_.correct(frame);
    TRY(take(frame, emit));
  }
  waiting_.clear();
  return {};
}

// The frames that are left are emitted first, under the last response; the state begins with the next.
Result<void> OnlineStage::begin_anew(const ResponseEstimate& estimate, int frame, const Emit& emit) {
  TRY(finish(emit));
  while (!steps_.empty()) retire_oldest();
  state_->forget_residuals();
  sensor_.begin_anew(estimate, frame);
  motion_ = make_motion_prior(camera_.height, camera_.width, pool_);
  field_rested_ = field_ != nullptr;
  white_ = 1;
  darkest_ = kAllBlack;
  return {};
}

std::unique_ptr<OnlineStage::Step> OnlineStage::spare_step() {
  if (spare_.empty()) return std::make_unique<Step>();
  auto step = std::move(spare_.back());
  spare_.pop_back();
  return step;
}

Result<void> OnlineStage::take(ExposedFrame& frame, const Emit& emit) {
  steps_.push_back(spare_step());
  Step& step = *steps_.back();
  std::swap(step.frame, frame);
  white_ = std::max(white_, 1 / step.frame.exposure);
  step.stated_blur = sensor_.count_blur(step.frame);
  step.advanced = step.emitted = false;
  const ExposureTables& tables = sensor_.tables_for(step.frame);

  if (steps_.size() == 1) {
    state_->restart({step.frame, tables, white_});
    lower_darkest(tables);
    step.motion.to_previous.vectors.reshape(0, 0, 0);
    step.motion.from_previous.vectors.reshape(0, 0, 0);
    step.advanced = true;
    TRY(fit(step));
  } else {
    Step& previous = *steps_[steps_.size() - 2];
    if (!previous.advanced) TRY(advance(previous, &step));
    Stopwatch watch;
    FlowField& onward = step.motion.from_previous;
    pool_.scratch().acquire(onward.vectors, 2, camera_.height, camera_.width);
    pool_.scratch().acquire(onward.confidence, 1, camera_.height, camera_.width);
    const bool learns = sensor_.learns_noise(step.frame),
               at_newer = SensorModel::noise_is_seen_in_newer(previous.frame, step.frame);
    const RatedFlows rated{.to_previous = learns && at_newer,
                           .from_previous = joins_newest() || (learns && !at_newer)};
    motion_->match(state_->state(), step.frame, tables,
                   {budget_.flow, budget_.blurs, before_ratio(steps_.size() - 1)}, rated, step.motion);
    if (timing_) timing_(Stage::Motion, watch.lap_ms());
    if (learns) {
      sensor_.learn_noise(previous.frame, step.frame, step.motion);
      if (timing_) timing_(Stage::Noise, watch.lap_ms());
    }
    if (look_ahead_ == 0) TRY(advance(step, nullptr));
  }
  return emit_ready(false, emit);
}

Result<void> OnlineStage::advance(Step& step, const Step* after) {
  Stopwatch watch;
  std::size_t at = 0;
  while (steps_[at].get() != &step) ++at;
  MotionContext context{.before_ratio = before_ratio(at)};
  if (after != nullptr) {
    const Instant before = time_before(at, 1);
    context.after = &after->frame;
    context.after_tables = &sensor_.tables_for(after->frame);
    context.after_ratio = ratio(step.frame.facts.timestamp - before, after->frame.facts.timestamp - before);
  }
  motion_->complete(state_->state(), step.frame, context, budget_.flow,
                    {.from_previous = field_takes_part() || look_ahead_ > 1}, step.motion);
  if (timing_) timing_(Stage::Motion, watch.lap_ms());

  // before the state takes the frame in: the frame must not be compared with itself
  sensor_.compare(step.frame, step.stated_blur, step.motion.to_previous, white_);
  if (look_ahead_ > 1 && at > 0 && !steps_[at - 1]->emitted) keep_state(*steps_[at - 1]);
  state_->advance({step.frame, sensor_.tables_for(step.frame), white_, budget_.blurs},
                  step.motion.to_previous);
  lower_darkest(sensor_.tables_for(step.frame));
  sensor_.take_over_residuals(step.frame);
  step.advanced = true;
  if (timing_) timing_(Stage::State, watch.lap_ms());
  TRY(fit(step));
  if (look_ahead_ < 2) end_look_along(step);  // else frames before it still do
  return {};
}

// The state goes on from this step, which is emitted later.
void OnlineStage::keep_state(Step& step) {
  const auto keep = [this](const Image<float>& part, Image<float>& kept) {
    pool_.scratch().acquire(kept, part.channels(), part.rows(), part.cols());
    copy(part, kept, pool_);
  };
  keep(state_->state().radiance, step.state.radiance);
  keep(state_->state().variance, step.state.variance);
  keep(state_->state().own_share, step.state.own_share);
}

// No earlier frame looks along the motion to this one any more.
void OnlineStage::end_look_along(Step& step) {
  pool_.scratch().release(step.motion.from_previous.vectors);
  pool_.scratch().release(step.motion.from_previous.confidence);
}

// The instant of the n-th frame before steps_[at], one or two.
Instant OnlineStage::time_before(std::size_t at, std::size_t n) const {
  return at >= n ? steps_[at - n]->frame.facts.timestamp : retired_times_[n - at - 1];
}

// The time that a step takes over that of the step before it.
float OnlineStage::before_ratio(std::size_t at) const {
  if (retired_ + at < 2) return 1;
  const Instant before = time_before(at, 1);
  return ratio(steps_[at]->frame.facts.timestamp - before, before - time_before(at, 2));
}

Result<void> OnlineStage::fit(Step& step) {
  step.in_field = field_takes_part();
  if (!step.in_field) {
    field_rested_ = true;
    step.T_world_camera = {};
    return {};
  }
  Stopwatch watch;
  const bool starts = !field_ || field_rested_;
  if (starts) start_second_layer(step.frame);
  const StateMotion none;  // the frame before is not in the field
  const StateMotion& motion = starts ? none : step.motion;
  const SeenFrame seen{step.frame, state_->state(), motion};
  const CameraPose& pose = poses_->estimate(seen);
  const DepthMap& depth = *(depth_map_ = &depth_->estimate(seen, pose));
  step.T_world_camera = pose.T_world_camera;
  step.pose = stated_pose(step.frame, pose);
  if (look_ahead_ > 1) step.depth.copy_from(depth);
  if (timing_) timing_(Stage::Pose, watch.lap_ms());
  TRY(field_->observe({step.frame, state_->state(), white_, motion, pose, depth, sensor_.response()}));
  step.fit = field_->fit(budget_.fit);
  if (timing_) timing_(Stage::Fit, watch.lap_ms());
  return {};
}

// What outputs state of a pose that the prior found. A given one keeps the recording's own numbers.
std::optional<FramePose> OnlineStage::stated_pose(const ExposedFrame& frame, const CameraPose& pose) const {
  if (poses_->source() == PoseSource::Given) return given_pose(frame.facts);
  return FramePose{pose.T_world_camera, poses_->source(), pose.lost, world_};
}

// Pose, depth and field begin, or begin anew after a rest: what they knew is of another time.
void OnlineStage::start_second_layer(const ExposedFrame& first) {
  field_rested_ = false;
  ++world_;
  if (!field_) has_poses_ = first.facts.T_world_camera.has_value();  // a unit of length for all of the run
  poses_ = make_pose_prior(knobs_.pose, camera_, has_poses_, pool_);
  DepthOptions depth = knobs_.depth;
  // no finer than the field's blocks can use, and half as fine where nobody looks at it
  const bool seen = knobs_.field_step != FieldStep::Auto;
  depth.step_px = std::max(depth.step_px, seen ? field_step_ / 2 : 2 * field_step_);
  depth_ = std::make_unique<DynamicDepth>(depth, knobs_.dynamic_depth, lens_, camera_.height, camera_.width,
                                          pool_);
  if (field_) return field_->restart();
  FieldOptions options = knobs_.hash_grid;
  options.step_px = field_step_;
  field_ = make_scene_field(knobs_.field, options,
                            {lens_, camera_.height, camera_.width, poses_->near(), gpu_}, pool_);
}

Result<void> OnlineStage::emit_ready(bool all, const Emit& emit) {
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    Step& step = *steps_[i];
    const std::size_t ahead = std::min(static_cast<std::size_t>(look_ahead_), steps_.size() - 1 - i);
    if (step.emitted) continue;
    if (!step.advanced || (!all && static_cast<int>(ahead) < look_ahead_)) break;
    if (budget_.emits || all) {
      TRY(emit_step(i, ahead, emit));
    } else {
      step.emitted = true;
      if (left_out_) left_out_();
    }
  }
  // the newest stays, because the next frame is compared with it
  while (steps_.size() > 1 && steps_.front()->emitted) retire_oldest();
  return {};
}

void OnlineStage::retire_oldest() {
  retired_times_ = {steps_.front()->frame.facts.timestamp, retired_times_[0]};
  ++retired_;
  RadianceState& kept = steps_.front()->state;
  for (Image<float>* part : {&kept.radiance, &kept.variance, &kept.own_share}) pool_.scratch().release(*part);
  spare_.push_back(std::move(steps_.front()));
  steps_.erase(steps_.begin());
  if (!steps_.empty() && steps_.front()->advanced) end_look_along(*steps_.front());
}

Result<void> OnlineStage::emit_step(std::size_t i, std::size_t ahead, const Emit& emit) {
  Stopwatch watch;
  Step& step = *steps_[i];
  std::array<LaterFrame, kMaxLookAhead> later;
  for (std::size_t k = 0; k < ahead; ++k) {
    const Step& next = *steps_[i + 1 + k];
    later[k] = {&next.frame, &next.motion.from_previous, &sensor_.tables_for(next.frame)};
  }
  const ScratchLease room(
      pool_.scratch(), camera_.height, camera_.width,
      {{&joined_.radiance, 3}, {&joined_.variance, 3}, {&joined_.own_share, 1}, {&joined_.later_share, 1}});
  const bool kept = !step.state.radiance.empty();
  const std::size_t joining = std::min(ahead, static_cast<std::size_t>(budget_.later_frames));
  state_->join(kept ? step.state : state_->state(), {later.data(), joining}, white_, joined_);
  SceneView view;
  view.T_world_camera = step.T_world_camera;
  view.time_s = step.frame.facts.timestamp.seconds();
  view.lens = lens_, view.rows = camera_.height, view.cols = camera_.width;
  step.emitted = true;
  const bool given = knobs_.pose == PoseKind::Given;
  const FrameEstimate estimate{
      .frame = step.frame,
      .state = joined_,
      .to_previous = step.motion.to_previous.empty() ? nullptr : &step.motion.to_previous,
      .to_next = ahead > 0 ? &later[0].from_previous->vectors : nullptr,
      .field = FieldNow(step.in_field ? field_.get() : nullptr),
      .view = view,
      .pose = step.in_field ? step.pose
              : given       ? given_pose(step.frame.facts)
                            : std::nullopt,
      .depth = step.in_field ? (look_ahead_ > 1 ? &step.depth : depth_map_) : nullptr,
      .depth_unit = poses_ ? poses_->near() : 1,
      .length_unit = poses_ ? unit_of(poses_->source()) : LengthUnit::Metre,
      .lens_is_assumed = !camera_.intrinsics,
      .fit = step.in_field ? &step.fit : nullptr,
      .noise_origin = sensor_.noise_origin(),
      .budget = budget_,
      .darkest = darkest_,
      .white = white_,
      .reference_exposure = step.frame.reference_exposure};
  if (timing_) timing_(Stage::LookAhead, watch.lap_ms());
  return emit(estimate);
}

// The state takes in a frame of these tables.
void OnlineStage::lower_darkest(const ExposureTables& tables) {
  for (int c = 0; c < 3; ++c) {
    float& darkest = darkest_[static_cast<std::size_t>(c)];
    darkest = std::min(darkest, tables.radiance(c, clip_policy::kBlack));
  }
}

Result<void> OnlineStage::finish(const Emit& emit) {
  if (!waiting_.empty()) TRY(bootstrap(emit));
  if (!steps_.empty() && !steps_.back()->advanced) TRY(advance(*steps_.back(), nullptr));
  return emit_ready(true, emit);
}

}  // namespace hdrcam
