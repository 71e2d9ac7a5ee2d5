#include "render/render_stage.h"

#include <cmath>

#include "hal/core/stopwatch.h"

namespace hdrcam {
namespace {

// Bilinear, pixel centres at +0.5: in at every `step`-th pixel -> out at all.
void enlarge(const Image<float>& in, int step, int rows, int cols, Image<float>& out, WorkerPool& pool) {
  out.reshape(in.channels(), rows, cols);
  if (step == 1) {
    out.copy_from(in);
    return;
  }
  const float scale = 1 / static_cast<float>(step);
  pool.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float sy =
          std::clamp((static_cast<float>(y) + 0.5f) * scale - 0.5f, 0.f, static_cast<float>(in.rows() - 1));
      const int ya = std::min(static_cast<int>(sy), in.rows() - 1), yb = std::min(ya + 1, in.rows() - 1);
      const float fy = sy - static_cast<float>(ya);
      for (int x = 0; x < cols; ++x) {
        const float sx =
            std::clamp((static_cast<float>(x) + 0.5f) * scale - 0.5f, 0.f, static_cast<float>(in.cols() - 1));
        const int xa = std::min(static_cast<int>(sx), in.cols() - 1), xb = std::min(xa + 1, in.cols() - 1);
        const float fx = sx - static_cast<float>(xa);
        for (int c = 0; c < in.channels(); ++c) {
          const float top = in.at(c, ya, xa) + fx * (in.at(c, ya, xb) - in.at(c, ya, xa));
          const float bottom = in.at(c, yb, xa) + fx * (in.at(c, yb, xb) - in.at(c, yb, xa));
          out.at(c, y, x) = top + fy * (bottom - top);
        }
      }
    }
  });
}

}  // namespace

void RenderStage::render(const FrameEstimate& estimate, HdrFrame& frame) {
  Stopwatch watch;
  const auto lap = [&](const char* stage) {
    if (timing_) timing_(stage, watch.lap_ms());
  };
  emission_.render(estimate, frame);
  frame.depth.reshape(0, 0, 0);
  frame.field_flow.reshape(0, 0, 0);
  lap("emission");
  if (!estimate.field || options_.layer == EmitLayer::State) return;
  look_into_field(estimate, frame);
  if (options_.layer == EmitLayer::Field)
    take_all(frame);
  else
    fill_unseen(estimate, frame);
  lap("field render");
}

void RenderStage::look_into_field(const FrameEstimate& estimate, HdrFrame& frame) {
  // alone, the field is rendered at full size; to fill unseen pixels a coarser view suffices
  const int step = options_.layer == EmitLayer::Field ? 1 : estimate.budget.render_step;
  estimate.field->look(reduced(estimate.view, step), pool_, view_);
  const int rows = frame.radiance.rows(), cols = frame.radiance.cols();
  enlarge(view_.radiance, step, rows, cols, radiance_, pool_);
  enlarge(view_.depth, step, rows, cols, frame.depth, pool_);
  if (!options_.shows_field_flow) return;
  enlarge(view_.flow[static_cast<int>(Neighbour::Previous)], step, rows, cols, frame.field_flow, pool_);
  for (float& px : frame.field_flow.samples())
    px *= static_cast<float>(step);  // in pixels of the full-size picture
}

void RenderStage::take_all(HdrFrame& frame) {
  frame.radiance.copy_from(radiance_);
  frame.provenance.fill(static_cast<std::uint8_t>(Provenance::Field));
}

// Where no frame saw a channel unclipped the state holds a lower bound; the field may raise it.
void RenderStage::fill_unseen(const FrameEstimate& estimate, HdrFrame& frame) {
  const float known = known_limit(estimate.white);
  const int cols = frame.radiance.cols();
  const Image<float>& variance = estimate.state.variance;
  pool_.for_rows(frame.radiance.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        bool answered = false;
        for (int c = 0; c < 3; ++c) {
          if (variance.at(c, y, x) < known) continue;
          float& bound = frame.radiance.at(c, y, x);
          const float answer = std::min(radiance_.at(c, y, x), options_.largest_answer * bound);
          if (answer > bound) bound = answer, answered = true;
        }
        if (answered) frame.provenance.at(0, y, x) = static_cast<std::uint8_t>(Provenance::Field);
      }
  });
}

}  // namespace hdrcam
