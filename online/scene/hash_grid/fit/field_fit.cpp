#include "online/scene/hash_grid/fit/field_fit.h"

#include <spdlog/spdlog.h>

#include <numeric>

#include "online/scene/field_snapshot.h"
#include "online/scene/hash_grid/fit/losses/response_smoothness.h"
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

FieldShape shape_of(const FieldOptions& options, int rows, int cols) {
  FieldShape shape = options.shape;
  shape.dynamic_grid.slots = options.window.frames + 1;
  for (HashGridShape* grid : {&shape.static_grid, &shape.dynamic_grid})
    grid->v_ratio = static_cast<float>(rows) / static_cast<float>(cols);
  return shape;
}

// Resamples a grid of the old anchor's window into the new one's. `before` is scratch memory for one table.
void carry_over(HashGrid<float>& grid, const ViewGeometry<double>& old_anchor,
                const ViewGeometry<double>& moved, std::vector<float>& before) {
  for (int l = 0; l < grid.shape().levels; ++l) {
    const HashLevel& level = grid.level(l);
    const std::span<float> table = grid.table(l);
    if (!level.dense) {
      std::fill(table.begin(), table.end(), 0.f);
      continue;
    }
    before.assign(table.begin(), table.end());
    const int vertices[3] = {static_cast<int>(level.cells[0]) + 1, static_cast<int>(level.cells[1]) + 1,
                             static_cast<int>(level.cells[2]) + 1};
    for (int slot = 0; slot < grid.shape().slots; ++slot)
      for (int k = 0; k < vertices[2]; ++k)
        for (int j = 0; j < vertices[1]; ++j)
          for (int i = 0; i < vertices[0]; ++i) {
            const double at[3] = {i / static_cast<double>(level.cells[0]),
                                  j / static_cast<double>(level.cells[1]),
                                  k / static_cast<double>(level.cells[2])};
            // a window point of the new anchor is a pixel and an inverse depth of its camera
            double pixel[3], x[3];
            old_anchor.project(at, pixel, nullptr);
            moved.place(pixel, old_anchor.inverse_depth(at[2]), x);
            const float position[3] = {static_cast<float>(x[0]), static_cast<float>(x[1]),
                                       static_cast<float>(x[2])};
            const auto corners = grid_corners(level, position, slot);
            const std::size_t entry =
                static_cast<std::size_t>(slot) * level.entries + static_cast<std::size_t>(i) +
                static_cast<std::size_t>(j) * level.stride[1] + static_cast<std::size_t>(k) * level.stride[2];
            for (std::size_t f = 0; f < 2; ++f) {
              float value = 0;
              for (int c = 0; c < 8; ++c) value += corners.weight[c] * before[2 * corners.entry[c] + f];
              table[2 * entry + f] = value;
            }
          }
  }
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
      networks_(shape_of(options, rows, cols), state_.random),
      static_(networks_.static_),
      dynamic_(networks_.dynamic),
      probe_(networks_, kMaxSamples) {
  for (int i = 0; i < window_.slots(); ++i)
    state_.pickers.emplace_back(window_.frustum().rows, window_.frustum().cols);
  for (HashGrid<float>* grid : {&networks_.static_.grid, &networks_.dynamic.grid})
    for (int l = 0; l < grid->shape().levels; ++l)
      table_before_.reserve(std::max(table_before_.capacity(), grid->table(l).size()));
  if (gpu != nullptr) {
    auto device = VulkanFit::make(*gpu, networks_);
    sums_ = std::make_unique<StepSums>();
    if (device)
      device_ = std::move(*device);
    else
      fall_back_to_cpu(device.error());
  }
  prepare({});
}

FieldFit::~FieldFit() = default;

void FieldFit::prepare(const FitBudget& budget) {
  CHECK(budget.rays_per_step >= kRaysPerShard && budget.rays_per_step % kRaysPerShard == 0);
  CHECK(budget.samples_per_ray <= kMaxSamples && budget.samples_without_parallax <= kMaxSamples);
  settle();
  budget_ = budget;
  samples_per_ray_ = window_.has_parallax() ? budget.samples_per_ray : budget.samples_without_parallax;
  rays_.resize(static_cast<std::size_t>(budget.rays_per_step));
  misfits_.resize(rays_.size());
  if (device_ != nullptr) return;
  const int most = std::max(budget.samples_per_ray, budget.samples_without_parallax);
  if (most > most_samples_) shards_.clear(), most_samples_ = most;
  while (static_cast<int>(shards_.size()) * kRaysPerShard < budget.rays_per_step)
    shards_.emplace_back(networks_, kRaysPerShard, most_samples_);
}

Result<void> FieldFit::observe(const FieldObservation& seen, const Response& response) {
  Window& window = window_;
  settle();
  refresh_guide();
  const int previous_slot = window.size() > 0 ? window.newest().slot : -1;
  TRY(window.advance(seen, pool_));
  if (!options_.fits_response || !response_started_) state_.response.start_from(response);
  response_started_ = true;

  const int slot = window.newest().slot;
  if (previous_slot >= 0) {  // a new frame starts from its predecessor's parameters
    HashGrid<float>& grid = networks_.dynamic.grid;
    for (Image<float>* values : {&grid.tables(), &dynamic_.table_mean, &dynamic_.table_variance})
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
  static_.keep();
  dynamic_.keep();
  ready_ = true;
}

void FieldFit::restart() {
  begun_.is_open = false;  // nobody asks for those steps any more
  window_.clear();
  start_networks();
  state_.health.forget();
  state_.taken = 0;
}

StepReport FieldFit::step() {
  StepReport report;
  if (window_.size() == 0) return report;
  make_ready();
  if (device_ != nullptr && !begun_.is_open) begin_on_gpu();
  draw_rays();
  const StepSetting<float> setting{networks_,
                                   window_,
                                   state_.response,
                                   options_.losses,
                                   samples_per_ray_,
                                   true,
                                   has_dynamic_,
                                   options_.fits_response,
                                   1.f / static_cast<float>(rays_.size())};
  if (device_ == nullptr) {
    gradients_cpu(setting, report);
  } else if (const Result<void> done = gradients_gpu(setting, report); !done) {
    fall_back_to_cpu(done.error());
    return step();
  }
  report.verdict = state_.health.judge(report.total, report.gradient_norm);
  if (!has_dynamic_) ++state_.health.counts().without_dynamic;
  switch (report.verdict) {
    case StepVerdict::Taken:
      ++state_.taken;
      apply(state_.health.gradient_scale());
      break;
    case StepVerdict::RolledBack:
      if (state_.health.is_lost()) {
        start_networks();
        state_.health.restart();
      } else {
        static_.restore();
        dynamic_.restore();
      }
      begun_.is_open = false;  // what is on a device is given up, too
      break;
    case StepVerdict::Skipped:
      break;
  }
  for (std::size_t r = 0; r < rays_.size(); ++r) {
    const TrainingRay& ray = rays_[r];
    state_.pickers[static_cast<std::size_t>(window_.frame(ray.frame).slot)].learn(
        static_cast<int>(ray.pixel[0]), static_cast<int>(ray.pixel[1]), misfits_[r]);
  }
  if (begun_.is_open) ++begun_.steps;
  return report;
}

void FieldFit::gradients_cpu(const StepSetting<float>& setting, StepReport& report) {
  const std::span<RayShard<float>> used = shards();
  const long number = state_.health.counts().steps;
  pool_.for_each(static_cast<int>(used.size()), [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    const std::span<const TrainingRay> rays(rays_.data() + at * kRaysPerShard, kRaysPerShard);
    const auto stream = static_cast<std::uint64_t>(number) * used.size() + at;
    used[at].run(setting, rays, Pcg32(options_.seed, stream));
  });
  report.gradient_norm = reduce(report);
  for (std::size_t s = 0; s < used.size(); ++s)
    std::copy_n(used[s].misfits().begin(), kRaysPerShard,
                misfits_.begin() + static_cast<std::ptrdiff_t>(s * kRaysPerShard));
}

Result<void> FieldFit::gradients_gpu(const StepSetting<float>& setting, StepReport& report) {
  if (begun_.steps == 0)
    TRY(device_->begin(window_, static_, dynamic_, {budget_.rays_per_step, samples_per_ray_, has_dynamic_}));
  const auto first_stream =
      static_cast<std::uint64_t>(state_.health.counts().steps) * (rays_.size() / kRaysPerShard);
  TRY(device_->gradients(setting, rays_, options_.seed, first_stream, pool_, static_, dynamic_, *sums_));
  report.losses = sums_->losses;
  d_response_ = sums_->d_response;
  misfits_ = sums_->misfits;
  report.gradient_norm = total_up(sums_->feature_energy, report);
  return {};
}

// The steps that follow, up to settle(), leave the parameters here as they are.
void FieldFit::begin_on_gpu() {
  begun_.is_open = true;
  begun_.steps = 0;
  begun_.state = state_;
}

void FieldFit::settle() {
  if (!begun_.is_open) return;
  if (const Result<void> done = device_->collect(static_, dynamic_); !done)
    return fall_back_to_cpu(done.error());
  begun_.is_open = false;
}

// The processor takes the steps that the device has not given back, the same ones again.
void FieldFit::fall_back_to_cpu(const Error& why) {
  fallback_reason_ = why.message;
  spdlog::warn("the fit of the field goes on with the processor: {}", fallback_reason_);
  device_.reset();
  if (!begun_.is_open) return;
  state_ = *begun_.state;
  begun_.is_open = false;
  prepare(budget_);
  for (int again = begun_.steps; again > 0; --again) step();
}

void FieldFit::draw_rays() {
  const Window& window = window_;
  const std::size_t count = shards().size();
  const auto newest = static_cast<std::size_t>(options_.newest_share * static_cast<float>(rays_.size()));
  for (std::size_t r = 0; r < rays_.size(); ++r) {
    const int frame = r < newest ? window.size() - 1 : state_.random.below(window.size());
    int x = 0, y = 0;
    state_.pickers[static_cast<std::size_t>(window.frame(frame).slot)].pick(state_.random, x, y);
    // interleaved over the shards, so that each has a fair part of the newest frame
    rays_[r % count * kRaysPerShard + r / count] = ray_at(frame, x, y);
  }
}

TrainingRay FieldFit::ray_at(int index, int x, int y) {
  const WindowFrame& frame = window_.frame(index);
  const BasePixel& base = frame.base.at(0, y, x);
  TrainingRay ray;
  ray.frame = index;
  ray.pixel[0] = static_cast<float>(x) + 0.5f, ray.pixel[1] = static_cast<float>(y) + 0.5f;
  ray.guide = base[kBaseSurface];
  for (int c = 0; c < 3; ++c) {
    ray.values[c] = frame.values.at(c, y, x);
    ray.state_log_radiance[c] = base[kBaseLogRadiance + static_cast<std::size_t>(c)];
    ray.state_trust[c] = 1 - base[kBaseGate + static_cast<std::size_t>(c)];
  }
  const float blur_px = std::hypot(base[kBaseFlow + 2], base[kBaseFlow + 3]) * frame.blur_fraction;
  ray.sharpness = 1 / (1 + blur_px * blur_px);
  if (!frame.depth_prior.empty()) {
    ray.depth_prior = frame.depth_prior.at(0, y, x);
    ray.depth_confidence = std::isfinite(ray.depth_prior) ? 1.f : 0.f;
  }
  const bool next = index + 1 < window_.size() && frame.has_flow[0];
  const bool previous = index > 0 && frame.has_flow[1];
  if (has_dynamic_ && (next || previous)) {
    ray.toward = next && (!previous || state_.random.below(2) == 0) ? Neighbour::Next : Neighbour::Previous;
    aim_at_neighbour(ray);
  }
  return ray;
}

// The flow prior as a pixel of the neighbour.
void FieldFit::aim_at_neighbour(TrainingRay& ray) {
  const Window& window = window_;
  const auto n = static_cast<std::size_t>(ray.toward);
  const WindowFrame& here = window.frame(ray.frame);
  const WindowFrame& there = window.frame(ray.frame + (ray.toward == Neighbour::Next ? 1 : -1));
  const BasePixel& base = here.base.at(0, static_cast<int>(ray.pixel[1]), static_cast<int>(ray.pixel[0]));
  float x[3];
  ViewGeometry<float>(window.frustum(), here.T_anchor_camera).place(ray.pixel, ray.guide, x);
  x[0] += base[kBaseFlow + 2 * n] * static_cast<float>(window.frustum().u_per_px());
  x[1] += base[kBaseFlow + 2 * n + 1] * static_cast<float>(window.frustum().v_per_px());
  float landing[3];
  ViewGeometry<float>(window.frustum(), there.T_anchor_camera).project(x, landing, nullptr);
  for (int a = 0; a < 2; ++a) ray.flow_prior[a] = landing[a];
  const auto cols = static_cast<float>(window.frustum().cols),
             rows = static_cast<float>(window.frustum().rows);
  ray.warps = ray.flow_prior[0] >= 0 && ray.flow_prior[1] >= 0 && ray.flow_prior[0] < cols &&
              ray.flow_prior[1] < rows;
  ray.flow_confidence = base[kBaseConfidence + n];
}

// Sums the shards' results in their order; returns the gradient's norm.
double FieldFit::reduce(StepReport& report) {
  double energy = 0;
  for (auto& channel : d_response_) channel.fill(0);
  for (OptimisedBranch* part : {&static_, &dynamic_})
    std::fill(part->d_network.begin(), part->d_network.end(), 0.f);
  for (RayShard<float>& shard : shards()) {
    for (std::size_t i = 0; i < report.losses.size(); ++i)
      report.losses[i] += static_cast<double>(shard.losses()[i]);
    for (std::size_t i = 0; i < static_.d_network.size(); ++i) static_.d_network[i] += shard.d_static()[i];
    for (std::size_t i = 0; i < dynamic_.d_network.size(); ++i) dynamic_.d_network[i] += shard.d_dynamic()[i];
    energy += shard.feature_energy();
    if (!options_.fits_response) continue;
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t j = 0; j < d_response_[c].size(); ++j) d_response_[c][j] += shard.d_response()[c][j];
  }
  return total_up(energy, report);
}

// The loss of the step as a whole; returns the gradient's norm.
double FieldFit::total_up(double feature_energy, StepReport& report) {
  double energy = feature_energy;
  if (options_.fits_response)
    report.losses[static_cast<std::size_t>(LossTerm::ResponseSmoothness)] = static_cast<double>(
        response_smoothness_loss(options_.losses[static_cast<std::size_t>(LossTerm::ResponseSmoothness)],
                                 state_.response, d_response_));
  report.total = std::accumulate(report.losses.begin(), report.losses.end(), 0.0);
  for (const OptimisedBranch* part : {&static_, &dynamic_})
    for (float d : part->d_network) energy += static_cast<double>(d) * static_cast<double>(d);
  return std::sqrt(energy);
}

void FieldFit::apply(float gradient_scale) {
  const float warm = std::min(1.f, static_cast<float>(state_.taken) / 20);
  const AdamStep table_step =
      adam_step(options_.adam, options_.table_rate * warm, gradient_scale, state_.taken);
  const AdamStep network_step =
      adam_step(options_.adam, options_.network_rate * warm, gradient_scale, state_.taken);
  if (device_ != nullptr)
    device_->take(table_step, network_step);
  else
    apply_cpu(table_step, network_step);
  if (options_.fits_response) apply_response(gradient_scale);
}

void FieldFit::apply_cpu(const AdamStep& table_step, const AdamStep& network_step) {
  const int static_levels = static_.branch.grid.shape().levels;
  const int dynamic_levels = has_dynamic_ ? dynamic_.branch.grid.shape().levels : 0;
  pool_.for_each(static_levels + dynamic_levels, [&](int i) {
    const bool is_static = i < static_levels;
    OptimisedBranch& part = is_static ? static_ : dynamic_;
    const int level = is_static ? i : i - static_levels;
    HashGrid<float>& grid = part.branch.grid;
    for (const RayShard<float>& shard : shards())
      is_static ? shard.scatter_static(level, grid) : shard.scatter_dynamic(level, grid);
    apply_adam(table_step, grid.table(level), grid.d_table(level), part.table_mean.plane(level),
               part.table_variance.plane(level));
  });
  for (OptimisedBranch* part : {&static_, &dynamic_})
    apply_adam(network_step, part->branch.mlp.parameters(), part->d_network, part->network.mean.data(),
               part->network.variance.data());
}

void FieldFit::apply_response(float gradient_scale) {
  std::array<std::array<float, LearnedResponse<float>::kSegments>, 3> d_increment{};
  state_.response.backward(d_response_, d_increment);
  const AdamStep step = adam_step(options_.adam, options_.response_rate, gradient_scale, state_.taken);
  for (std::size_t c = 0; c < 3; ++c)
    apply_adam(step, state_.response.increments()[c], d_increment[c],
               state_.response_moments.mean.data() + c * d_increment[c].size(),
               state_.response_moments.variance.data() + c * d_increment[c].size());
  state_.response.rebuild();
}

// The depth that the networks have learned for the newest frame, where no prior knows it, becomes the guide
// of its rays and, carried along the flow, of the next frame's. Half of the tiles, in turn, a frame.
void FieldFit::refresh_guide() {
  Window& window = window_;
  if (window.size() == 0 || !window.has_parallax()) return;
  WindowFrame& frame = window.writable(window.size() - 1);
  const ProbeView view{frame.T_anchor_camera, window.size() - 1, 0};
  ProbeRay rays[FieldProbe::kRays];
  ProbeAnswer answers[FieldProbe::kRays];
  float* guides[FieldProbe::kRays];
  std::size_t waiting = 0;
  const auto look = [&] {
    probe_.look(field(), view, {rays, waiting}, {answers, waiting});
    for (std::size_t i = 0; i < waiting; ++i) *guides[i] = std::clamp(answers[i].inverse_depth, 0.01f, 0.95f);
    waiting = 0;
  };
  for (int y = 0; y < frame.guide.rows(); ++y)
    for (int x = 0; x < frame.guide.cols(); ++x) {
      if (frame.prior_guides.at(0, y, x) != 0 || (x + y + frame.index) % 2 != 0) continue;
      float& guide = frame.guide.at(0, y, x);
      rays[waiting] = {{static_cast<float>(x * kGuideStep) + kGuideStep / 2.f,
                        static_cast<float>(y * kGuideStep) + kGuideStep / 2.f},
                       guide};
      guides[waiting++] = &guide;
      if (waiting == FieldProbe::kRays) look();
    }
  if (waiting > 0) look();
}

// Moves the anchor to the newest frame. The grids are carried over level by level: a dense level is
// resampled at the old position of each of its vertices; hashed levels, which cannot be enumerated, start at
// zero.
void FieldFit::reanchor() {
  const RigidTransform T_old_new = window_.move_anchor().inverse();
  const ViewGeometry<double> old_anchor(window_.frustum(), RigidTransform()),
      moved(window_.frustum(), T_old_new);
  for (OptimisedBranch* part : {&static_, &dynamic_})
    carry_over(part->branch.grid, old_anchor, moved, table_before_);
  ++state_.health.counts().anchors_moved;
}

FieldNetworks<float> FieldFit::fresh_networks(std::uint64_t seed) const {
  Pcg32 random(seed);
  return {shape_of(options_, window_.frustum().rows, window_.frustum().cols), random};
}

void FieldFit::start_networks() {
  networks_.copy_parameters(fresh_networks(state_.random.next()));
  for (OptimisedBranch* part : {&static_, &dynamic_}) {
    part->keep();
    part->restore();
  }
}

}  // namespace hdrcam
