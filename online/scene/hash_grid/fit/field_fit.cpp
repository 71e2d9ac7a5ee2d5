#include "online/scene/hash_grid/fit/field_fit.h"

#include <spdlog/spdlog.h>

#include <numeric>

#include "online/scene/field_snapshot.h"
#include "online/scene/hash_grid/fit/guide_refresh.h"
#include "online/scene/hash_grid/fit/losses/response_smoothness.h"
#include "online/scene/hash_grid/fit/ray_drawing.h"
#include "online/scene/hash_grid/fit/reanchor.h"
#include "online/scene/hash_grid/fit/vulkan/vulkan_fit.h"

namespace hdrcam {
namespace {

// Of a stream of pictures of this camera and size.
WindowFrustum frustum_of(const FieldOptions& options, Intrinsics camera, int rows, int cols) {
  // without a calibration: a normal lens, 53 degrees across; only novel views notice
  if (!(camera.fx_px > 0) || !(camera.fy_px > 0))
    camera = {static_cast<double>(cols), static_cast<double>(cols), 0.5 * cols, 0.5 * rows};
  SceneView view;
  view.lens = camera, view.rows = rows, view.cols = cols;
  view = reduced(view, options.step_px);
  return {view.lens, view.rows, view.cols, options.margin, options.near, options.step_px};
}

FieldShape shape_of(const FieldOptions& options, const WindowFrustum& frustum) {
  FieldShape shape = options.shape;
  shape.dynamic_grid.slots = options.window.frames + 1;
  for (HashGridShape* grid : {&shape.static_grid, &shape.dynamic_grid})
    grid->v_ratio = static_cast<float>(frustum.rows) / static_cast<float>(frustum.cols);
  return shape;
}

}  // namespace

FieldFit::FieldFit(const FieldOptions& options, const Intrinsics& camera, int rows, int cols,
                   WorkerPool& pool, GpuDevice* gpu)
    : options_(options),
      pool_(pool),
      state_{.random = Pcg32(options.seed),
             .response = LearnedResponse<float>(Response::linear()),
             .response_moments = AdamMoments(3 * LearnedResponse<float>::kSegments),
             .pickers = {},
             .health = {}},
      window_(frustum_of(options, camera, rows, cols), options.window),
      networks_(shape_of(options, window_.frustum()), state_.random),
      branches_(networks_),
      probe_(networks_, kMaxSamples) {
  for (int i = 0; i < window_.slots(); ++i)
    state_.pickers.emplace_back(window_.frustum().rows, window_.frustum().cols);
  for (HashGrid<float>* grid : {&networks_.static_.grid, &networks_.dynamic.grid})
    for (int l = 0; l < grid->shape().levels; ++l)
      table_before_.reserve(std::max(table_before_.capacity(), grid->table(l).size()));
  if (gpu != nullptr) {
    auto made = VulkanFit::make(*gpu, networks_);
    if (made)
      gpu_ = std::move(*made);
    else
      fall_back_to_cpu(made.error());
  }
  prepare({});
}

FieldFit::~FieldFit() = default;

void FieldFit::prepare(const FitBudget& budget) {
  HDRCAM_CHECK(budget.rays_per_step >= kRaysPerShard && budget.rays_per_step % kRaysPerShard == 0);
  HDRCAM_CHECK(budget.samples_per_ray <= kMaxSamples && budget.samples_without_parallax <= kMaxSamples);
  settle();
  budget_ = budget;
  samples_per_ray_ = window_.has_parallax() ? budget.samples_per_ray : budget.samples_without_parallax;
  rays_.resize(static_cast<std::size_t>(budget.rays_per_step));
  sums_.misfits.resize(rays_.size());
  if (gpu_ == nullptr)
    cpu_.reserve(networks_, budget.rays_per_step,
                 std::max(budget.samples_per_ray, budget.samples_without_parallax));
}

Result<void> FieldFit::observe(const FieldObservation& seen, const Response& response) {
  Window& window = window_;
  settle();
  refresh_guide(window, field(), probe_);
  const int previous_slot = window.size() > 0 ? window.newest().slot : -1;
  TRY(window.advance(seen, pool_));
  if (!options_.fits_response || became_another(response)) state_.response.start_from(response);

  const int slot = window.newest().slot;
  if (previous_slot >= 0) {  // a new frame starts from its predecessor's parameters
    HashGrid<float>& grid = networks_.dynamic.grid;
    OptimisedBranch& optimised = branches_.dynamic;
    for (Image<float>* values : {&grid.tables(), &optimised.table_mean, &optimised.table_variance})
      grid.copy_slot(previous_slot, slot, *values);
    state_.pickers[static_cast<std::size_t>(slot)] = state_.pickers[static_cast<std::size_t>(previous_slot)];
  }
  state_.pickers[static_cast<std::size_t>(slot)].look_at(window.newest());
  if (window.anchor_is_stale()) reanchor();
  has_dynamic_ = options_.shape.branches == Branches::Dynamic ||
                 (options_.shape.branches == Branches::Both && window.has_motion());
  prepare(budget_);
  ready_ = false;
  return {};
}

// What only a frame with steps pays for.
void FieldFit::make_ready() {
  if (ready_) return;
  for (int i = 0; i < window_.size(); ++i)
    state_.pickers[static_cast<std::size_t>(window_.frame(i).slot)].prepare(options_.uniform_share);
  for (OptimisedBranch* part : branches_.both()) part->keep();
  ready_ = true;
}

bool FieldFit::became_another(const Response& response) {
  bool another = false;
  for (std::size_t c = 0; c < estimate_.size(); ++c) {
    const Response::Curve& curve = response.inverse(static_cast<int>(c));
    if (curve != estimate_[c]) estimate_[c] = curve, another = true;
  }
  return another;
}

void FieldFit::restart() {
  uncollected_.is_open = false;  // nobody asks for those steps any more
  window_.clear();
  start_networks();
  state_.health.forget();
  forget_steps();
}

StepReport FieldFit::step() {
  StepReport report;
  if (window_.size() == 0) return report;
  make_ready();
  if (gpu_ != nullptr && !uncollected_.is_open) begin_on_gpu();
  draw_rays(window_, {options_.newest_share, has_dynamic_}, state_.pickers, state_.random, rays_);
  if (const Result<void> done = gradients(); !done) {
    fall_back_to_cpu(done.error());
    return step();
  }
  report.gradient_norm = total_up(report);
  report.verdict = state_.health.judge(report.total, report.gradient_norm);
  if (!has_dynamic_) ++state_.health.counts().without_dynamic;
  switch (report.verdict) {
    case StepVerdict::Taken:
      ++state_.taken;
      apply(state_.health.gradient_scale());
      break;
    case StepVerdict::RolledBack:
      roll_back();
      break;
    case StepVerdict::Skipped:
      break;
  }
  learn_misfits(window_, rays_, sums_.misfits, state_.pickers);
  if (uncollected_.is_open) ++uncollected_.steps;
  return report;
}

// The losses of the drawn rays and their gradients, into sums_ and the branches' d_network. Errors: those of
// the device.
Result<void> FieldFit::gradients() {
  const StepSetting<float> setting{.networks = networks_,
                                   .window = window_,
                                   .response = state_.response,
                                   .weights = options_.losses,
                                   .samples_per_ray = samples_per_ray_,
                                   .has_dynamic = has_dynamic_,
                                   .fits_response = options_.fits_response,
                                   .ray_share = 1.f / static_cast<float>(rays_.size())};
  const ShardStreams random{.seed = options_.seed,
                            .first_stream = static_cast<std::uint64_t>(state_.health.counts().steps) *
                                            (rays_.size() / kRaysPerShard)};
  if (gpu_ == nullptr) {
    cpu_.gradients(setting, rays_, random, pool_, branches_, sums_);
    return {};
  }
  if (uncollected_.steps == 0)
    TRY(gpu_->begin(window_, branches_, {budget_.rays_per_step, samples_per_ray_, has_dynamic_}));
  return gpu_->gradients(setting, rays_, random, pool_, branches_, sums_);
}

// The loss of the step as a whole; returns the gradient's norm.
double FieldFit::total_up(StepReport& report) {
  report.losses = sums_.losses;
  if (options_.fits_response)
    report.losses[static_cast<std::size_t>(LossTerm::ResponseSmoothness)] = static_cast<double>(
        response_smoothness_loss(options_.losses[static_cast<std::size_t>(LossTerm::ResponseSmoothness)],
                                 state_.response, sums_.d_response));
  report.total = std::accumulate(report.losses.begin(), report.losses.end(), 0.0);
  double energy = sums_.feature_energy;
  for (const OptimisedBranch* part : branches_.both())
    for (float d : part->d_network) energy += static_cast<double>(d) * static_cast<double>(d);
  return std::sqrt(energy);
}

void FieldFit::apply(float gradient_scale) {
  constexpr float kWarmUp = 20;  // steps over which the rates rise: Adam's moments say little before
  const float warm = std::min(1.f, static_cast<float>(state_.taken) / kWarmUp);
  const AdamStep table_step =
      adam_step(options_.adam, options_.table_rate * warm, gradient_scale, state_.taken);
  const AdamStep network_step =
      adam_step(options_.adam, options_.network_rate * warm, gradient_scale, state_.taken);
  if (gpu_ != nullptr)
    gpu_->take(table_step, network_step);
  else
    cpu_.take(table_step, network_step, pool_, branches_);
  if (options_.fits_response) apply_response(gradient_scale);
}

void FieldFit::apply_response(float gradient_scale) {
  std::array<std::array<float, LearnedResponse<float>::kSegments>, 3> d_increment{};
  state_.response.backward(sums_.d_response, d_increment);
  const AdamStep step = adam_step(options_.adam, options_.response_rate, gradient_scale, state_.taken);
  for (std::size_t c = 0; c < 3; ++c)
    apply_adam(step, state_.response.increments()[c], d_increment[c],
               state_.response_moments.mean.data() + c * d_increment[c].size(),
               state_.response_moments.variance.data() + c * d_increment[c].size());
  state_.response.rebuild();
}

void FieldFit::roll_back() {
  if (state_.health.is_lost()) {
    start_networks();
    state_.health.restart();
  } else {
    for (OptimisedBranch* part : branches_.both()) part->restore();
  }
  forget_steps();
  uncollected_.is_open = false;  // what is on a device is given up, too
}

// Of branches that were restored Adam knows nothing, so it begins anew for all: the number of steps, by which
// it corrects moments that start at zero, is one for branches and response.
void FieldFit::forget_steps() {
  state_.response_moments.forget();
  state_.taken = 0;
}

// The steps that follow, up to settle(), leave the parameters of field() as they are.
void FieldFit::begin_on_gpu() {
  uncollected_.is_open = true;
  uncollected_.steps = 0;
  uncollected_.state = state_;
}

void FieldFit::settle() {
  if (!uncollected_.is_open) return;
  if (const Result<void> done = gpu_->collect(branches_); !done) return fall_back_to_cpu(done.error());
  uncollected_.is_open = false;
}

// The CPU takes the steps that were not collected again, the same ones: from the state before them.
void FieldFit::fall_back_to_cpu(const Error& why) {
  fallback_reason_ = why.message;
  spdlog::warn("the fit of the field goes on with the processor: {}", fallback_reason_);
  gpu_.reset();
  if (!uncollected_.is_open) return;
  state_ = *uncollected_.state;
  uncollected_.is_open = false;
  prepare(budget_);
  for (int again = uncollected_.steps; again > 0; --again) step();
}

// Moves the anchor to the newest frame. Adam keeps how large gradients are, and forgets where they led: that
// was of other places.
void FieldFit::reanchor() {
  const RigidTransform T_old_new = window_.move_anchor().inverse();
  for (OptimisedBranch* part : branches_.both()) {
    carry_over(part->branch.grid, window_.frustum(), T_old_new, table_before_);
    part->table_mean.fill(0);
  }
  ++state_.health.counts().anchors_moved;
}

FieldNetworks<float> FieldFit::fresh_networks(std::uint64_t seed) const {
  Pcg32 random(seed);
  return {shape_of(options_, window_.frustum()), random};
}

void FieldFit::start_networks() {
  networks_.copy_parameters(fresh_networks(state_.random.next()));
  for (OptimisedBranch* part : branches_.both()) {
    part->keep();
    part->restore();
  }
}

}  // namespace hdrcam
