#include "render/render_stage.h"

#include <algorithm>

#include "online/pictures/copy_in_parallel.h"
#include "render/enlarge.h"
#include "render/surface_points.h"

namespace hdrcam {

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
  // until anything shows a depth the field's is where the fit began, which says nothing
  const bool tells_depth = estimate.depth != nullptr && estimate.depth->tells();
  if (options_.depth != DepthLayer::None && tells_depth) {
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

// The field's layers are rendered at one pixel in step x step; none where no layer of it is asked for.
std::optional<int> RenderStage::step_of_layers(int render_step) const {
  constexpr int kGlanceStep = 8;
  if (options_.depth == DepthLayer::Whole || options_.shows_field_flow) return render_step;
  if (options_.depth == DepthLayer::Glance) return std::max(render_step, kGlanceStep);
  return std::nullopt;
}

// The field is rendered where it fills, and elsewhere only where another of its layers is asked for.
void RenderStage::fill_unseen(const FrameEstimate& estimate, HdrFrame& frame) {
  const int step = estimate.budget.render_step;
  const std::optional<int> of_layers = step_of_layers(step);
  if (of_layers) render_field(estimate, *of_layers, frame);
  if (!estimate.budget.fills || !unseen_.mark(estimate, step)) return;
  if (of_layers != step) {
    SceneView view = reduced(estimate.view, step);
    view.wanted = &unseen_.marked();
    estimate.field->look(view, pool_, view_);
  }
  unseen_.raise(estimate, view_.radiance, step, frame);
}

}  // namespace hdrcam
