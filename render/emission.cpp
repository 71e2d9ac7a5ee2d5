#include "render/emission.h"

#include <cmath>

namespace hdrcam {

void Emission::render(const FrameEstimate& estimate, HdrFrame& frame) {
  constexpr float kDarkOffset =
      1 / 5000.f;  // of white: below it differences are not visible after mu-law, mu = 5000
  const float offset = estimate.white * kDarkOffset;
  frame.facts = estimate.frame.facts;
  frame.exposure = estimate.frame.exposure;
  frame.reference_exposure = estimate.reference_exposure;
  frame.white = estimate.white;
  frame.pose = estimate.pose;
  frame.length_unit = estimate.length_unit;
  frame.lens = estimate.view.lens;
  frame.lens_is_assumed = estimate.lens_is_assumed;
  judge(estimate, offset, frame);
  frame.radiance.copy_from(estimate.state.radiance);
  if (estimate.budget.shrinks) shrinkage_.apply(frame.radiance, estimate.state.variance, offset);
  if (estimate.to_previous != nullptr)
    frame.flow.copy_from(estimate.to_previous->vectors);
  else
    frame.flow.reshape(0, 0, 0);
}

// The source of each pixel and its uncertainty.
void Emission::judge(const FrameEstimate& estimate, float offset, HdrFrame& frame) {
  const JoinedState& state = estimate.state;
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  const float known = known_limit(estimate.white);
  frame.sigma.reshape(1, rows, cols);
  frame.provenance.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        float worst = 0, relative = 0;
        for (int c = 0; c < 3; ++c) {
          const float r = state.radiance.at(c, y, x) + offset, v = state.variance.at(c, y, x);
          worst = std::max(worst, v);
          relative += v / (r * r) * (1 / 3.f);
        }
        const float later = state.later_share.at(0, y, x), own = state.own_share.at(0, y, x) * (1 - later);
        Provenance from = Provenance::Carried;
        if (worst >= known)
          from = Provenance::Bound;
        else if (later > 0.5f)
          from = Provenance::LookAhead;
        else if (own > 0.5f)
          from = Provenance::Own;
        frame.provenance.at(0, y, x) = static_cast<std::uint8_t>(from);
        frame.sigma.at(0, y, x) = std::min(10.f, std::sqrt(relative));
      }
  });
}

}  // namespace hdrcam
