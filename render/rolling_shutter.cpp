#include "render/rolling_shutter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "online/pictures/between_pixels.h"
#include "online/pictures/warp.h"

namespace hdrcam {
namespace {

// From motion between rows to motion in one interval: what moves to another row is seen there a little
// earlier or later than an interval away. time: of the neighbour, in intervals.
Offset in_one_interval(Offset seen, float time, float row_time) {
  constexpr float kMostLater = 0.5f;  // intervals
  return (1 / (1 + std::clamp(time * seen.y * row_time, -kMostLater, kMostLater))) * seen;
}
void make_of_one_interval(Image<float>& flow, float time, float row_time, WorkerPool& pool) {
  if (flow.empty()) return;
  pool.for_rows(flow.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < flow.cols(); ++x) {
        const Offset motion = in_one_interval(offset_at(flow, x, y), time, row_time);
        flow.at(0, y, x) = motion.x, flow.at(1, y, x) = motion.y;
      }
  });
}

// The first where it is not a number.
int nearest(int place, float by, int size) {
  const float to = static_cast<float>(place) + by;
  return static_cast<int>(std::min(std::max(0.f, to + 0.5f), static_cast<float>(size - 1)));
}

}  // namespace

void RollingShutterCorrection::correct(const FrameEstimate& estimate, double readout_s, HdrFrame& frame) {
  // Between centres of exposures: shorter than a frame before a short one.
  constexpr double kMostIntervals = 2;
  const double interval_s = estimate.frame.interval_s;
  const bool moves_unknown = estimate.to_previous == nullptr && estimate.to_next == nullptr;
  if (!(readout_s > 0) || !(interval_s > 0) || readout_s > kMostIntervals * interval_s || moves_unknown)
    return;
  const float row_time = static_cast<float>(readout_s / interval_s / frame.radiance.rows());
  const Motion motion = estimate.to_previous != nullptr ? Motion{estimate.to_previous->vectors, -1, row_time}
                                                        : Motion{*estimate.to_next, 1, row_time};
  const ScratchLease borrowed(pool_.scratch(), frame.radiance.rows(), frame.radiance.cols(),
                              {{&sources_, 2}});
  find_sources(motion);
  move_layers(frame);
  for (Image<float>* flow : {&frame.flow, &frame.field_flow})
    make_of_one_interval(*flow, -1, row_time, pool_);
  for (Image<float>* flow : {&frame.flow_forward, &frame.field_flow_forward})
    make_of_one_interval(*flow, 1, row_time, pool_);
  move_points(motion, frame);
}

// What is at a place at the frame's moment is seen by another row, which it reaches while rows are read on.
// With constant motion that row's distance, and the time to the neighbour's row that sees it again, change by
// the same factor: the way there is the motion times what the place's own row is late. A fixed point, because
// the motion is that of the pixel where it is seen.
void RollingShutterCorrection::find_sources(const Motion& motion) {
  constexpr int kRounds = 2;
  const Image<float>& vectors = motion.vectors;
  const int rows = vectors.rows(), cols = vectors.cols();
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float late = motion.row_time * (static_cast<float>(y) - 0.5f * static_cast<float>(rows));
      for (int x = 0; x < cols; ++x) {
        Offset source = motion.time * late * offset_at(vectors, x, y);
        for (int round = 1; round < kRounds; ++round)
          source =
              motion.time * late * offset_at(vectors, nearest(x, source.x, cols), nearest(y, source.y, rows));
        if (!std::isfinite(source.x + source.y)) source = {};
        sources_.at(0, y, x) = source.x, sources_.at(1, y, x) = source.y;
      }
    }
  });
}

void RollingShutterCorrection::move_layers(HdrFrame& frame) {
  for (Image<float> HdrFrame::*layer : kFloatLayers) {
    Image<float>& picture = frame.*layer;
    if (picture.empty()) continue;
    if (layer == &HdrFrame::radiance)
      warp_radiance(picture, sources_, moved_, pool_);
    else
      warp_linear(picture, sources_, moved_, pool_);
    std::swap(picture, moved_);
  }
  const int rows = sources_.rows(), cols = sources_.cols();
  provenance_.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x)
        provenance_.at(0, y, x) = frame.provenance.at(0, nearest(y, sources_.at(1, y, x), rows),
                                                      nearest(x, sources_.at(0, y, x), cols));
  });
  std::swap(frame.provenance, provenance_);
}

// Those that leave the picture are left out.
void RollingShutterCorrection::move_points(const Motion& motion, HdrFrame& frame) const {
  const int rows = motion.vectors.rows(), cols = motion.vectors.cols();
  for (SurfacePoint& point : frame.points) {
    const auto x = static_cast<float>(point.u_px) - 0.5f, y = static_cast<float>(point.v_px) - 0.5f;
    const Offset seen = offset_at(motion.vectors, nearest(0, x, cols), nearest(0, y, rows));
    const float late = motion.row_time * (y - 0.5f * static_cast<float>(rows));
    const Offset way = motion.time * late * in_one_interval(seen, motion.time, motion.row_time);
    point.u_px -= static_cast<double>(way.x), point.v_px -= static_cast<double>(way.y);
  }
  std::erase_if(frame.points, [&](const SurfacePoint& point) {
    return !(point.u_px >= 0 && point.u_px < cols && point.v_px >= 0 && point.v_px < rows);
  });
}

}  // namespace hdrcam
