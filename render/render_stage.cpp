#include "render/render_stage.h"

#include <cmath>

#include "online/pictures/between_pixels.h"
#include "online/pictures/copy_in_parallel.h"
#include "render/surface_points.h"

namespace hdrcam {
namespace {

// Where a full-size pixel reads, along one axis, a picture of every `step`-th pixel.
AxisTap reduced_tap(int at, int step, int size) {
  return tap_at((static_cast<float>(at) + 0.5f) / static_cast<float>(step) - 0.5f, size);
}

void enlarge(const Image<float>& in, int step, int rows, int cols, Image<float>& out, WorkerPool& pool) {
  out.reshape(in.channels(), rows, cols);
  if (step == 1) {
    out.copy_from(in);
    return;
  }
  pool.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const AxisTap tap_y = reduced_tap(y, step, in.rows());
      for (int x = 0; x < cols; ++x) {
        const BetweenPixels place(tap_y, reduced_tap(x, step, in.cols()));
        for (int c = 0; c < in.channels(); ++c) out.at(c, y, x) = place.of(in, c);
      }
    }
  });
}

}  // namespace

void RenderStage::render(const FrameEstimate& estimate, HdrFrame& frame) {
  render_as_read(estimate, frame);
  StageWatch watch(timing_);
  rolling_shutter_.correct(estimate, options_.readout_s.value_or(frame.facts.readout_s), frame);
  watch.lap(Stage::Emission);
}

// Each row as it was when it was read.
void RenderStage::render_as_read(const FrameEstimate& estimate, HdrFrame& frame) {
  StageWatch watch(timing_);
  emission_.render(estimate, frame);
  for (Image<float>* layer : {&frame.depth, &frame.field_flow, &frame.field_flow_forward})
    layer->reshape(0, 0, 0);
  show_motion_and_points(estimate, frame);
  watch.lap(Stage::Emission);
  if (!estimate.field || options_.layer == EmitLayer::State) return;
  if (options_.layer == EmitLayer::Field)
    emit_field(estimate, frame);
  else
    fill_unseen(estimate, frame);
  watch.lap(Stage::FieldRender);
}

void RenderStage::show_motion_and_points(const FrameEstimate& estimate, HdrFrame& frame) {
  const auto show = [this](bool wanted, const Image<float>* vectors, Image<float>& flow) {
    if (wanted && vectors != nullptr)
      copy_in_parallel(*vectors, flow, pool_);
    else
      flow.reshape(0, 0, 0);
  };
  const FlowField* backward = estimate.to_previous;
  show(options_.shows_flow_backward, backward != nullptr ? &backward->vectors : nullptr, frame.flow);
  show(options_.shows_flow_forward, estimate.to_next, frame.flow_forward);
  if (options_.shows_points) find_surface_points(estimate, frame.radiance, frame.points);
}

// The view of the frame at one pixel in step x step; its depth and flow as layers.
void RenderStage::render_field(const FrameEstimate& estimate, int step, HdrFrame& frame) {
  estimate.field->look(reduced(estimate.view, step), pool_, view_);
  const int rows = frame.radiance.rows(), cols = frame.radiance.cols();
  if (options_.depth != DepthLayer::None) {
    enlarge(view_.depth, step, rows, cols, frame.depth, pool_);
    for (float& z : frame.depth.samples()) z *= estimate.depth_unit;
  }
  if (!options_.shows_field_flow) return;
  for (const auto& [toward, flow] :
       {std::pair(Neighbour::Previous, &frame.field_flow), {Neighbour::Next, &frame.field_flow_forward}}) {
    enlarge(view_.flow[static_cast<std::size_t>(toward)], step, rows, cols, *flow, pool_);
    for (float& px : flow->samples()) px *= static_cast<float>(step);  // in pixels of the full-size picture
  }
}

void RenderStage::emit_field(const FrameEstimate& estimate, HdrFrame& frame) {
  render_field(estimate, 1, frame);
  frame.radiance.copy_from(view_.radiance);
  frame.provenance.fill(static_cast<std::uint8_t>(Provenance::Field));
}

// The pixels of a reduced view that unseen pixels read; false where every pixel was seen.
bool RenderStage::mark_unseen(const FrameEstimate& estimate, int step) {
  const float known = estimate.unseen_variance;
  const Image<float>& variance = estimate.state.variance;
  const SceneView view = reduced(estimate.view, step);
  unseen_.reshape(1, view.rows, view.cols);
  unseen_.fill(0);
  bool any = false;
  for (int y = 0; y < variance.rows(); ++y) {
    const AxisTap tap_y = reduced_tap(y, step, view.rows);
    for (int x = 0; x < variance.cols(); ++x) {
      if (std::max({variance.at(0, y, x), variance.at(1, y, x), variance.at(2, y, x)}) < known) continue;
      const AxisTap tap_x = reduced_tap(x, step, view.cols);
      for (const int v : {tap_y.low, tap_y.high})
        for (const int u : {tap_x.low, tap_x.high}) unseen_.at(0, v, u) = 1;
      any = true;
    }
  }
  return any;
}

// Where no frame saw a channel unclipped the state holds a lower bound; the field may raise it, if it shall:
// by half of the stops that it says, which is nearer to the truth than either. It is rendered there, and
// elsewhere only where another of its layers is asked for.
void RenderStage::fill_unseen(const FrameEstimate& estimate, HdrFrame& frame) {
  constexpr int kGlanceStep = 8;
  const int step = estimate.budget.render_step;
  const bool whole = options_.depth == DepthLayer::Whole || options_.shows_field_flow;
  if (options_.depth == DepthLayer::Glance && !whole)
    render_field(estimate, std::max(step, kGlanceStep), frame);
  if (whole) render_field(estimate, step, frame);
  if (!estimate.budget.fills || !mark_unseen(estimate, step)) return;
  if (!whole) {
    SceneView view = reduced(estimate.view, step);
    view.wanted = &unseen_;
    estimate.field->look(view, pool_, view_);
  }

  const float known = estimate.unseen_variance;
  const int cols = frame.radiance.cols();
  const Image<float>& variance = estimate.state.variance;
  pool_.for_rows(frame.radiance.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const AxisTap tap_y = reduced_tap(y, step, view_.radiance.rows());
      for (int x = 0; x < cols; ++x) {
        bool raised = false;
        for (int c = 0; c < 3; ++c) {
          if (variance.at(c, y, x) < known) continue;
          const AxisTap tap_x = reduced_tap(x, step, view_.radiance.cols());
          float& bound = frame.radiance.at(c, y, x);
          const float from_field = std::min(BetweenPixels(tap_y, tap_x).of(view_.radiance, c),
                                            options_.largest_field_ratio * bound);
          if (from_field > bound) bound = std::sqrt(from_field * bound), raised = true;
        }
        if (raised) frame.provenance.at(0, y, x) = static_cast<std::uint8_t>(Provenance::Field);
      }
    }
  });
}

}  // namespace hdrcam
