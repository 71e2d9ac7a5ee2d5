#include "online/field_stage.h"

#include <limits>

#include "hal/core/stopwatch.h"

namespace hdrcam {
namespace {

// Tracked poses count in the median depth of the first view, given ones in metres.
constexpr float kNearOfTracked = 0.25f, kNearOfGiven = 0.5f;

PoseKind kind_of(const FieldStageOptions& options, bool has_poses) {
  return has_poses ? PoseKind::Given : options.pose;
}

Intrinsics lens_of(const CameraFacts& camera) {
  return camera.intrinsics ? *camera.intrinsics : assumed_intrinsics(camera.height, camera.width);
}

FieldOptions with_near(FieldOptions options, float near) {
  options.near = near;
  return options;
}

}  // namespace

FieldStage::FieldStage(const FieldStageOptions& options, const CameraFacts& camera, bool has_poses,
                       WorkerPool& pool)
    : pool_(pool),
      poses_(make_pose_source(kind_of(options, has_poses), camera)),
      depth_(options.depth, lens_of(camera), camera.height, camera.width, pool),
      near_(has_poses ? kNearOfGiven : kNearOfTracked),
      fit_(with_near(options.field, near_), lens_of(camera), camera.height, camera.width, pool) {}

Result<FitReport> FieldStage::advance(const ExposedFrame& frame, const RadianceState& state, float white,
                                      const StateMotion* motion, const Response& response,
                                      const Timing& timing) {
  Stopwatch watch;
  const FlowField& to_previous = motion != nullptr ? motion->to_previous : none_;
  const FlowField& from_previous = motion != nullptr ? motion->from_previous : none_;
  pose_ = &poses_->next(frame.facts, to_previous, from_previous);
  const DepthPrior& depth = depth_.next(*pose_, to_previous);
  if (timing) timing("pose", watch.lap_ms());

  // what the state hardly knows counts as unseen
  const float known = known_limit(white);
  variance_.copy_from(state.variance);
  for (float& v : variance_.samples()) v = v < known ? v : kUnseenVariance;
  FieldObservation seen;
  seen.index = frame.index;
  seen.time_s = frame.facts.timestamp.seconds();
  seen.exposure = frame.exposure;
  seen.blur_fraction = frame.blur_fraction;
  seen.codes = &frame.codes;
  seen.radiance = &state.radiance;
  seen.variance = &variance_;
  seen.to_previous = &to_previous;
  seen.from_previous = &from_previous;
  if (!depth.empty()) {
    spread(depth);
    seen.inverse_depth = &inverse_depth_;
  }
  seen.T_world_camera = pose_->T_world_camera;
  TRY(fit_.observe(seen, response));

  FitReport report;
  for (int i = 0; i < fit_.options().steps_per_frame; ++i) {
    const StepReport step = fit_.step();
    ++report.steps;
    if (step.verdict != StepVerdict::Taken) {
      ++report.rolled_back;
      continue;
    }
    for (std::size_t term = 0; term < report.losses.size(); ++term) report.losses[term] += step.losses[term];
  }
  const auto taken = static_cast<double>(std::max(1L, report.steps - report.rolled_back));
  for (double& loss : report.losses) loss /= taken;
  if (timing) timing("fit", watch.lap_ms());
  return report;
}

// The prior on the frame's own pixels, in the window's units; NaN where it is not believed.
void FieldStage::spread(const DepthPrior& depth) {
  constexpr float kBelieved = 0.5f;  // weight of a prior that is known to 100 percent
  const int rows = variance_.rows(), cols = variance_.cols();
  const int grid_rows = depth.weight.rows(), grid_cols = depth.weight.cols();
  inverse_depth_.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        const int v = y * grid_rows / rows, u = x * grid_cols / cols;
        inverse_depth_.at(0, y, x) = depth.weight.at(0, v, u) >= kBelieved
                                         ? std::min(1.f, depth.inverse_depth.at(0, v, u) * near_)
                                         : std::numeric_limits<float>::quiet_NaN();
      }
  });
}

}  // namespace hdrcam
