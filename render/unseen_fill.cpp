#include "render/unseen_fill.h"

#include <algorithm>
#include <cmath>

#include "render/enlarge.h"

namespace hdrcam {

bool UnseenFill::mark(const FrameEstimate& estimate, int step) {
  const Image<float>& variance = estimate.state.variance;
  const SceneView view = reduced(estimate.view, step);
  marked_.reshape(1, view.rows, view.cols);
  marked_.fill(0);
  bool any = false;
  for (int y = 0; y < variance.rows(); ++y) {
    const AxisTap tap_y = reduced_tap(y, step, view.rows);
    for (int x = 0; x < variance.cols(); ++x) {
      if (std::max({variance.at(0, y, x), variance.at(1, y, x), variance.at(2, y, x)}) <
          estimate.unseen_variance)
        continue;
      const AxisTap tap_x = reduced_tap(x, step, view.cols);
      for (const int v : {tap_y.low, tap_y.high})
        for (const int u : {tap_x.low, tap_x.high}) marked_.at(0, v, u) = 1;
      any = true;
    }
  }
  return any;
}

void UnseenFill::raise(const FrameEstimate& estimate, const Image<float>& field, int step,
                       HdrFrame& frame) const {
  const int cols = frame.radiance.cols();
  const Image<float>& variance = estimate.state.variance;
  pool_.for_rows(frame.radiance.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const AxisTap tap_y = reduced_tap(y, step, field.rows());
      for (int x = 0; x < cols; ++x) {
        bool raised = false;
        for (int c = 0; c < 3; ++c) {
          if (variance.at(c, y, x) < estimate.unseen_variance) continue;
          const BetweenPixels place(tap_y, reduced_tap(x, step, field.cols()));
          float& bound = frame.radiance.at(c, y, x);
          const float from_field = std::min(place.of(field, c), largest_ratio_ * bound);
          if (from_field > bound) bound = std::sqrt(from_field * bound), raised = true;
        }
        if (raised) frame.provenance.at(0, y, x) = static_cast<std::uint8_t>(Provenance::Field);
      }
    }
  });
}

}  // namespace hdrcam
