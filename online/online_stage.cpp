#include "online/online_stage.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/clip_policy.h"
#include "hal/core/stopwatch.h"
#include "online/pictures/copy_in_parallel.h"

namespace hdrcam {
namespace {

// Of intervals between time stamps, which may be wrong.
float ratio(Duration interval, Duration other) {
  if (interval <= Duration::zero() || other <= Duration::zero()) return 1;
  return static_cast<float>(std::clamp(to_seconds(interval) / to_seconds(other), 0.1, 10.0));
}

}  // namespace

struct OnlineStage::Step {
  ExposedFrame frame;
  float stated_blur = 0;               // share of its motion that blurs it by its facts
  StateMotion motion;                  // between the state at the frame before and this one
  std::optional<SceneEstimate> scene;  // none where the second layer rests
  // After this frame, where a later one has taken its place before this one was emitted. The state's pictures
  // are borrowed.
  RadianceState state;
  DepthMap depth;
  bool advanced = false, emitted = false;
};

OnlineStage::OnlineStage(const Knobs& knobs, const CameraFacts& camera,
                         const std::optional<Response>& response, WorkerPool& pool, GpuDevice* gpu)
    : knobs_(knobs),
      budget_(knobs.budget),
      camera_(camera),
      look_ahead_(look_ahead_of(knobs, camera.height, camera.width)),
      pool_(pool),
      gpu_(gpu),
      motion_(make_motion_prior(camera.height, camera.width, pool, gpu)),
      state_(make_state_layer(knobs.state, camera.height, camera.width, pool, gpu)),
      sensor_(knobs, camera, response, *state_, pool),
      second_layer_(knobs, camera, pool, gpu) {}

OnlineStage::~OnlineStage() = default;

Result<void> OnlineStage::ingest(ExposedFrame& frame, const FrameBudget& budget, const Emit& emit) {
  budget_ = budget;
  // nothing more between the field's pixels
  budget_.render_step = std::max(budget.render_step, second_layer_.field_step_px());
  sensor_.meet(frame);
  if (!sensor_.is_known()) {
    sensor_.see_first(frame, waiting_.empty() ? nullptr : &waiting_.back());
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
  motion_ = make_motion_prior(camera_.height, camera_.width, pool_, gpu_);
  second_layer_.rest();
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
    state_->restart({step.frame, tables, unseen_variance()});
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
                    {.from_previous = second_layer_takes_part() || look_ahead_ > 1}, step.motion);
  if (timing_) timing_(Stage::Motion, watch.lap_ms());

  // before the state takes the frame in: the frame must not be compared with itself
  sensor_.compare(step.frame, step.stated_blur, step.motion.to_previous, unseen_variance());
  if (look_ahead_ > 1 && at > 0 && !steps_[at - 1]->emitted) keep(*steps_[at - 1]);
  state_->advance({step.frame, sensor_.tables_for(step.frame), unseen_variance(), budget_.blurs},
                  step.motion.to_previous);
  lower_darkest(sensor_.tables_for(step.frame));
  sensor_.take_over_residuals(step.frame);
  step.advanced = true;
  if (timing_) timing_(Stage::State, watch.lap_ms());
  TRY(fit(step));
  if (look_ahead_ < 2) end_look_along(step);  // else frames before it still do
  return {};
}

// State and depth go on from this step, which is emitted later.
void OnlineStage::keep(Step& step) {
  const auto keep_part = [this](const Image<float>& part, Image<float>& kept) {
    pool_.scratch().acquire(kept, part.channels(), part.rows(), part.cols());
    copy_in_parallel(part, kept, pool_);
  };
  keep_part(state_->state().radiance, step.state.radiance);
  keep_part(state_->state().variance, step.state.variance);
  keep_part(state_->state().own_share, step.state.own_share);
  if (!step.scene) return;
  step.depth.copy_from(*step.scene->depth);
  step.scene->depth = &step.depth;
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
  step.scene.reset();
  if (!second_layer_takes_part()) {
    second_layer_.rest();
    return {};
  }
  step.scene = TRY(second_layer_.take({step.frame, state_->state(), step.motion}, unseen_variance(),
                                      sensor_.response(), budget_.fit));
  return {};
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
  const RadianceState& state = step.state.radiance.empty() ? state_->state() : step.state;
  const std::size_t joining = std::min(ahead, static_cast<std::size_t>(budget_.later_frames));
  const ScratchLease room(pool_.scratch(), joining > 0 ? camera_.height : 0, camera_.width,
                          {{&joined_.radiance, 3}, {&joined_.variance, 3}, {&joined_.later_share, 1}});
  if (joining > 0) state_->join(state, {later.data(), joining}, unseen_variance(), joined_);
  const std::optional<SceneEstimate>& scene = step.scene;
  SceneView view;
  if (scene) view.T_world_camera = scene->T_world_camera;
  view.time_s = step.frame.facts.timestamp.seconds();
  view.lens = second_layer_.lens(), view.rows = camera_.height, view.cols = camera_.width;
  step.emitted = true;
  const FrameEstimate estimate{
      .frame = step.frame,
      .state = joining > 0 ? static_cast<const RadianceEstimate&>(joined_) : state,
      .own_share = state.own_share,
      .later_share = joining > 0 ? &joined_.later_share : nullptr,
      .to_previous = step.motion.to_previous.empty() ? nullptr : &step.motion.to_previous,
      .to_next = ahead > 0 ? &later[0].from_previous->vectors : nullptr,
      .field = scene ? second_layer_.field() : FieldNow(),
      .view = view,
      .world = scene ? scene->world : 0,
      .pose = scene ? scene->pose : second_layer_.given_pose(step.frame.facts),
      .depth = scene ? scene->depth : nullptr,
      .depth_unit = second_layer_.depth_unit(),
      .length_unit = second_layer_.length_unit(),
      .lens_is_assumed = !camera_.intrinsics,
      .fit = scene ? &scene->fit : nullptr,
      .noise_origin = sensor_.noise_origin(),
      .budget = budget_,
      .darkest = darkest_,
      .white = white_,
      .unseen_variance = unseen_variance(),
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
