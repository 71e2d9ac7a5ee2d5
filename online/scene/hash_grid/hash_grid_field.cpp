#include "online/scene/hash_grid/hash_grid_field.h"

#include <limits>

#include "online/scene/hash_grid/field/field_renderer.h"

namespace hdrcam {
namespace {

FieldOptions with_near(FieldOptions options, float near) {
  options.near = near;
  return options;
}

}  // namespace

HashGridSnapshot::HashGridSnapshot(const FieldFit& fit, GpuDevice* gpu)
    : window_(fit.field().window.frustum()), networks_(fit.fresh_networks(1)), gpu_(gpu) {}

void HashGridSnapshot::look(const SceneView& view, WorkerPool& pool, FieldPicture& picture) const {
  auto* renderer = dynamic_cast<FieldRenderer*>(picture.buffers.get());
  if (renderer == nullptr) {
    picture.buffers = std::make_unique<FieldRenderer>(gpu_);
    renderer = static_cast<FieldRenderer*>(picture.buffers.get());
  }
  renderer->render({window_, networks_, samples_per_ray_, has_dynamic_}, view, pool, picture);
}

HashGridField::HashGridField(const FieldOptions& options, const SceneSetup& setup, WorkerPool& pool)
    : pool_(pool),
      gpu_(setup.gpu),
      fit_(with_near(options, setup.near), setup.lens, setup.rows, setup.cols, pool, setup.gpu) {}

HashGridField::~HashGridField() {
  for (const auto& snapshot : snapshots_) HDRCAM_CHECK(!snapshot->is_held());
}

Result<void> HashGridField::observe(const SceneObservation& seen) {
  for (const auto& snapshot : snapshots_)
    if (!snapshot->is_held()) Window::release(snapshot->window_);

  const ExposedFrame& frame = seen.frame;
  FieldObservation told;
  told.index = frame.index;
  told.time_s = frame.facts.timestamp.seconds();
  told.exposure = frame.exposure;
  told.blur_fraction = frame.blur_fraction;
  told.codes = &frame.codes;
  told.radiance = &seen.state.radiance;
  told.variance = &seen.state.variance;
  told.unseen_variance = seen.unseen_variance;
  told.to_previous = &seen.motion.to_previous;
  told.from_previous = &seen.motion.from_previous;
  if (!seen.depth.empty()) {
    spread(seen.depth);
    told.inverse_depth = &inverse_depth_;
  }
  told.T_world_camera = seen.pose.T_world_camera;
  return fit_.observe(told, seen.response);
}

FitReport HashGridField::fit(const FitBudget& budget) {
  FitReport report;
  LossValues<double> losses{};
  fit_.prepare(budget);
  if (frames_++ % budget.interval != 0) return report;
  for (int i = 0; i < budget.steps; ++i) {
    const StepReport step = fit_.step();
    ++report.steps;
    if (step.verdict != StepVerdict::Taken) {
      ++report.rolled_back;
      continue;
    }
    for (std::size_t term = 0; term < losses.size(); ++term) losses[term] += step.losses[term];
  }
  fit_.settle();
  const auto taken = static_cast<double>(std::max(1L, report.steps - report.rolled_back));
  for (std::size_t term = 0; term < losses.size(); ++term)
    if (losses[term] != 0) report.losses.push_back({kLosses[term].name, losses[term] / taken});
  return report;
}

void HashGridField::restart() {
  for (const auto& snapshot : snapshots_)
    if (!snapshot->is_held()) Window::release(snapshot->window_);
  fit_.restart();
  frames_ = 0;
}

SnapshotHold HashGridField::snapshot() {
  HashGridSnapshot* free = nullptr;
  for (const auto& snapshot : snapshots_)
    if (!snapshot->is_held()) free = snapshot.get();
  if (free == nullptr) {
    snapshots_.push_back(std::make_unique<HashGridSnapshot>(fit_, gpu_));
    free = snapshots_.back().get();
  }
  const RadianceField now = fit_.field();
  fit_.window().hold(free->window_);
  free->networks_.copy_parameters(now.networks);
  free->samples_per_ray_ = now.samples_per_ray;
  free->has_dynamic_ = now.has_dynamic;
  return SnapshotHold(*free);
}

// The prior on the window's pixels and in its units: the mean of what is believed of it there, NaN where
// nothing is.
void HashGridField::spread(const DepthMap& depth) {
  const WindowFrustum& frustum = fit_.window().frustum();
  const int rows = frustum.rows, cols = frustum.cols;
  const int grid_rows = depth.weight.rows(), grid_cols = depth.weight.cols();
  inverse_depth_.reshape(1, rows, cols);
  // points of the grid under a block: [first, last)
  const auto under = [&](int block, int points) {
    const int first = std::min(block * frustum.step_px / depth.step_px, points - 1);
    const int last = std::min((block + 1) * frustum.step_px / depth.step_px, points);
    return std::pair(first, std::max(first + 1, last));
  };
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        const auto [v0, v1] = under(y, grid_rows);
        const auto [u0, u1] = under(x, grid_cols);
        float sum = 0;
        int believed = 0;
        for (int v = v0; v < v1; ++v)
          for (int u = u0; u < u1; ++u)
            if (depth.weight.at(0, v, u) >= DepthMap::kBelieved)
              sum += std::min(1.f, depth.inverse_depth.at(0, v, u) * frustum.near), ++believed;
        inverse_depth_.at(0, y, x) =
            believed > 0 ? sum / static_cast<float>(believed) : std::numeric_limits<float>::quiet_NaN();
      }
  });
}

}  // namespace hdrcam
