#include "online/scene/hash_grid/field/surface_guide.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

float guide_at(const Image<float>& guide, int y, int x) {
  return guide.at(0, std::min(y / kGuideStep, guide.rows() - 1), std::min(x / kGuideStep, guide.cols() - 1));
}

}  // namespace

void carry_guide(const WindowFrustum& frustum, const WindowFrame& from, const FlowField& to_previous,
                 WindowFrame& to) {
  const int step = frustum.step_px;
  for (int y = 0; y < to.guide.rows(); ++y)
    for (int x = 0; x < to.guide.cols(); ++x) {
      const int px = std::min(x * kGuideStep + kGuideStep / 2, frustum.cols - 1);
      const int py = std::min(y * kGuideStep + kGuideStep / 2, frustum.rows - 1);
      const auto moved = [&](int axis, int at, int size) {
        const float flow = to_previous.vectors.at(axis, py * step, px * step);
        return std::isfinite(flow)
                   ? std::clamp(
                         at + static_cast<int>(std::lround(std::clamp(flow, -kMaxFlow_px, kMaxFlow_px) /
                                                           static_cast<float>(step))),
                         0, size - 1)
                   : at;
      };
      to.guide.at(0, y, x) = guide_at(from.guide, moved(1, py, frustum.rows), moved(0, px, frustum.cols));
    }
}

void guide_by_prior(const WindowFrustum& frustum, WindowFrame& frame) {
  frame.prior_guides.fill(0);
  if (frame.depth_prior.empty()) return;
  constexpr int kEnough = kGuideStep * kGuideStep / 4;
  for (int y = 0; y < frame.guide.rows(); ++y)
    for (int x = 0; x < frame.guide.cols(); ++x) {
      float sum = 0;
      int known = 0;
      for (int py = y * kGuideStep; py < std::min((y + 1) * kGuideStep, frustum.rows); ++py)
        for (int px = x * kGuideStep; px < std::min((x + 1) * kGuideStep, frustum.cols); ++px) {
          const float q = frame.depth_prior.at(0, py, px);
          if (std::isfinite(q)) sum += std::clamp(q, 0.f, 1.f), ++known;
        }
      if (known < kEnough) continue;
      frame.guide.at(0, y, x) = sum / static_cast<float>(known);
      frame.prior_guides.at(0, y, x) = 1;
    }
}

void take_surface(const WindowFrustum& frustum, WindowFrame& frame, WorkerPool& pool) {
  pool.for_rows(frustum.rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < frustum.cols; ++x) {
        const float prior = frame.depth_prior.empty() ? kNoValue : frame.depth_prior.at(0, y, x);
        frame.base.at(0, y, x)[kBaseSurface] = prior >= 0 && prior <= 1 ? prior : guide_at(frame.guide, y, x);
      }
  });
}

}  // namespace hdrcam
