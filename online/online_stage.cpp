#include "online/online_stage.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/clip_policy.h"
#include "capture/exposure.h"

namespace hdrcam {

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
      second_layer_(knobs, camera, pool, gpu),
      frames_(pool) {}

Result<void> OnlineStage::ingest(ExposedFrame& frame, const FrameBudget& budget, const Emit& emit) {
  budget_ = budget;
  // nothing more between the field's pixels
  budget_.render_step = std::max(budget.render_step, second_layer_.field_step_px());
  sensor_.meet(frame);
  if (!sensor_.is_known()) {
    sensor_.see_first(frame, first_frames_.empty() ? nullptr : &first_frames_.back());
    first_frames_.emplace_back(frame, camera_.bits);
    return static_cast<int>(first_frames_.size()) < knobs_.bootstrap_frames ? Result<void>()
                                                                            : bootstrap(emit);
  }
  StageWatch watch(timing_);
  if (const auto found = sensor_.learn_response(frame)) TRY(begin_anew(*found, frame.index, emit));
  sensor_.correct(frame);
  watch.lap(Stage::Unpack);
  return take(frame, emit);
}

// Response and black level from the first frames, which then take their way.
Result<void> OnlineStage::bootstrap(const Emit& emit) {
  sensor_.learn_first(first_frames_);
  ExposedFrame frame;
  for (CompactFrame& packed : first_frames_) {
    packed.restore(frame);
    packed = {};
    sensor_.correct(frame);
    TRY(take(frame, emit));
  }
  first_frames_.clear();
  return {};
}

// The frames that are left are emitted first, under the last response; the state begins with the next.
Result<void> OnlineStage::begin_anew(const ResponseEstimate& estimate, int frame, const Emit& emit) {
  TRY(end_scene(emit));
  state_->forget_residuals();
  sensor_.begin_anew(estimate, frame);
  whites_.clear();
  for (RecentValues& darkest : darkests_) darkest.clear();
  return {};
}

// What comes has nothing to do with the frames so far: those that wait are emitted without it.
Result<void> OnlineStage::end_scene(const Emit& emit) {
  TRY(emit_rest(emit));
  frames_.retire_all();
  motion_ = make_motion_prior(camera_.height, camera_.width, pool_, gpu_);
  second_layer_.rest();
  return {};
}

Result<void> OnlineStage::take(ExposedFrame& frame, const Emit& emit) {
  if (frames_.empty())
    cuts_.begin(frame);
  else if (cuts_.ends_before(frame))
    TRY(end_scene(emit));
  PendingFrame& newest = frames_.add(frame);
  whites_.add(1 / newest.frame.exposure);
  newest.stated_blur = sensor_.count_blur(newest.frame);
  const ExposureTables& tables = sensor_.tables_for(newest.frame);

  const std::size_t place = frames_.size() - 1;
  if (place == 0) {
    TRY(begin(newest, tables));
  } else {
    if (!frames_[place - 1].advanced) TRY(advance(place - 1));
    match(place, tables);
    if (look_ahead_ == 0) TRY(advance(place));
  }
  return emit_ready(Stream::GoesOn, emit);
}

// The state with the first frame, or the first of another scene or under another response.
Result<void> OnlineStage::begin(PendingFrame& first, const ExposureTables& tables) {
  state_->restart({first.frame, tables, unseen_variance()});
  note_darkest(tables);
  first.motion.to_previous.vectors.reshape(0, 0, 0);
  first.motion.from_previous.vectors.reshape(0, 0, 0);
  first.advanced = true;
  return fit(first);
}

// The motion between the state, which is at the frame before, and the newest frame; and the noise of both.
void OnlineStage::match(std::size_t place, const ExposureTables& tables) {
  StageWatch watch(timing_);
  const ExposedFrame& previous = frames_[place - 1].frame;
  PendingFrame& newest = frames_[place];
  frames_.borrow_motion_from_previous(place);
  const bool learns = sensor_.learns_noise(newest.frame),
             at_newer = SensorModel::noise_is_seen_in_newer(previous, newest.frame);
  const RatedFlows rated{.to_previous = learns && at_newer,
                         .from_previous = joins_newest() || (learns && !at_newer)};
  motion_->match(state_->state(), newest.frame, tables,
                 {budget_.flow, budget_.blurs, frames_.before_ratio(place)}, rated, newest.motion);
  sensor_.follow_light(newest.frame, newest.motion.to_previous, unseen_variance());
  watch.lap(Stage::Motion);
  if (!learns) return;
  sensor_.learn_noise(previous, newest.frame, newest.motion);
  watch.lap(Stage::Noise);
}

// The state goes on to this frame, then the second layer.
Result<void> OnlineStage::advance(std::size_t place) {
  StageWatch watch(timing_);
  PendingFrame& pending = frames_[place];
  MotionContext context{.before_ratio = frames_.before_ratio(place)};
  if (place + 1 < frames_.size()) {
    const ExposedFrame& after = frames_[place + 1].frame;
    context.after = &after;
    context.after_tables = &sensor_.tables_for(after);
    context.after_ratio = frames_.after_ratio(place);
  }
  motion_->complete(state_->state(), pending.frame, context,
                    std::min(budget_.flow, budget_.flow_over_clipped),
                    {.from_previous = second_layer_takes_part() || look_ahead_ > 1}, pending.motion);
  watch.lap(Stage::Motion);

  // before the state takes the frame in: the frame must not be compared with itself
  sensor_.compare(pending.frame, pending.stated_blur, pending.motion.to_previous, unseen_variance());
  if (look_ahead_ > 1 && place > 0 && !frames_[place - 1].emitted)
    frames_.keep_state(place - 1, state_->state());
  state_->advance({pending.frame, sensor_.tables_for(pending.frame), unseen_variance(), budget_.blurs},
                  pending.motion.to_previous);
  note_darkest(sensor_.tables_for(pending.frame));
  sensor_.take_over_residuals(pending.frame);
  pending.advanced = true;
  watch.lap(Stage::State);
  TRY(fit(pending));
  if (look_ahead_ < 2) frames_.return_motion_from_previous(place);  // else frames before it still look along
  return {};
}

Result<void> OnlineStage::fit(PendingFrame& pending) {
  pending.scene.reset();
  if (!second_layer_takes_part()) {
    second_layer_.rest();
    return {};
  }
  pending.scene = TRY(second_layer_.take({pending.frame, state_->state(), pending.motion}, unseen_variance(),
                                         sensor_.response(), budget_.fit));
  return {};
}

Result<void> OnlineStage::emit_ready(Stream stream, const Emit& emit) {
  for (std::size_t place = 0; place < frames_.size(); ++place) {
    PendingFrame& pending = frames_[place];
    const std::size_t ahead = std::min(static_cast<std::size_t>(look_ahead_), frames_.size() - 1 - place);
    if (pending.emitted) continue;
    const bool waits = stream == Stream::GoesOn && static_cast<int>(ahead) < look_ahead_;
    if (!pending.advanced || waits) break;
    pending.emitted = true;
    if (budget_.emits || stream == Stream::Ended) {
      TRY(emit_at(place, ahead, emit));
    } else if (left_out_) {
      left_out_();
    }
  }
  frames_.retire_emitted();
  return {};
}

LaterFrame OnlineStage::later_frame(std::size_t place, const ExposedFrame& emitted) {
  const PendingFrame& later = frames_[place];
  const float longer = std::log(later.frame.exposure / emitted.exposure);  // in ln
  return {&later.frame, &later.motion.from_previous, &sensor_.tables_for(later.frame),
          longer < -static_cast<float>(kSameExposure)};
}

Result<void> OnlineStage::emit_at(std::size_t place, std::size_t ahead, const Emit& emit) {
  StageWatch watch(timing_);
  const PendingFrame& pending = frames_[place];
  std::array<LaterFrame, kMaxLookAhead> later;
  for (std::size_t k = 0; k < ahead; ++k) later[k] = later_frame(place + 1 + k, pending.frame);
  const RadianceState& state = pending.state.radiance.empty() ? state_->state() : pending.state;
  const std::size_t joining = std::min(ahead, static_cast<std::size_t>(budget_.later_frames));
  const ScratchLease room(pool_.scratch(), joining > 0 ? camera_.height : 0, camera_.width,
                          {{&joined_.radiance, 3}, {&joined_.variance, 3}, {&joined_.later_share, 1}});
  if (joining > 0) state_->join(state, {later.data(), joining}, unseen_variance(), joined_);
  const std::optional<SceneEstimate>& scene = pending.scene;
  const FrameEstimate estimate{
      .frame = pending.frame,
      .state = joining > 0 ? static_cast<const RadianceEstimate&>(joined_) : state,
      .own_share = state.own_share,
      .later_share = joining > 0 ? &joined_.later_share : nullptr,
      .to_previous = pending.motion.to_previous.empty() ? nullptr : &pending.motion.to_previous,
      .to_next = ahead > 0 ? &later[0].from_previous->vectors : nullptr,
      .field = scene ? second_layer_.field_of(scene->world) : FieldNow(),
      .view = view_of(pending),
      .world = scene ? scene->world : 0,
      .pose = scene ? scene->pose : second_layer_.given_pose(pending.frame.facts),
      .depth = scene ? scene->depth : nullptr,
      .depth_unit = second_layer_.depth_unit(),
      .length_unit = second_layer_.length_unit(),
      .lens_is_assumed = !camera_.intrinsics,
      .fit = scene ? &scene->fit : nullptr,
      .noise_origin = sensor_.noise_origin(),
      .budget = budget_,
      .darkest = darkest(),
      .white = white(),
      .unseen_variance = unseen_variance(),
      .reference_exposure = pending.frame.reference_exposure,
      .neutral_gains = sensor_.neutral_gains()};
  watch.lap(Stage::LookAhead);
  return emit(estimate);
}

SceneView OnlineStage::view_of(const PendingFrame& pending) const {
  SceneView view;
  if (pending.scene) view.T_world_camera = pending.scene->T_world_camera;
  view.time_s = pending.frame.facts.timestamp.seconds();
  view.lens = second_layer_.lens(), view.rows = camera_.height, view.cols = camera_.width;
  return view;
}

// Called where the state takes in a frame of these tables.
void OnlineStage::note_darkest(const ExposureTables& tables) {
  for (int c = 0; c < 3; ++c)
    darkests_[static_cast<std::size_t>(c)].add(tables.radiance(c, clip_policy::kBlack));
}

std::array<float, 3> OnlineStage::darkest() const {
  constexpr float kAllBlack = 1e9f;
  return {darkests_[0].least(kAllBlack), darkests_[1].least(kAllBlack), darkests_[2].least(kAllBlack)};
}

Result<void> OnlineStage::finish(const Emit& emit) {
  if (!first_frames_.empty()) TRY(bootstrap(emit));
  return emit_rest(emit);
}

Result<void> OnlineStage::emit_rest(const Emit& emit) {
  if (!frames_.empty() && !frames_[frames_.size() - 1].advanced) TRY(advance(frames_.size() - 1));
  return emit_ready(Stream::Ended, emit);
}

}  // namespace hdrcam
