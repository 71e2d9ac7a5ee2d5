// The estimate of a frame of which only the state is known: for tests of what is made of an estimate, which
// add what else they need. Reentrant.
#pragma once

#include "online/frame_estimate.h"

namespace hdrcam::test {

// Without motion, later frames, field, view or pose; radiance 1 is white. What is given outlives the
// estimate.
inline FrameEstimate estimate_by_state(const ExposedFrame& frame, const RadianceEstimate& state,
                                       const Image<float>& own_share) {
  return {.frame = frame,
          .state = state,
          .own_share = own_share,
          .to_previous = nullptr,
          .field = {},
          .view = {},
          .fit = nullptr,
          .budget = {},
          .white = 1,
          .unseen_variance = 1,
          .reference_exposure = 1};
}

}  // namespace hdrcam::test
