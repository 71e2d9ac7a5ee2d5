// What a frame's estimate tells those who choose exposures: its state and its motion, without a field.
#pragma once

#include "online/frame_estimate.h"
#include "online/state/radiance_state.h"

namespace hdrcam::test {

constexpr float kWhite = 16;

// All outlive the estimate; to_next: null where it is not known.
inline FrameEstimate estimate_of(const ExposedFrame& frame, const RadianceState& state,
                                 const FlowField& to_previous, const Image<float>* to_next,
                                 double reference_exposure) {
  return {.frame = frame,
          .state = state,
          .own_share = state.own_share,
          .to_previous = &to_previous,
          .to_next = to_next,
          .field = {},
          .view = {},
          .fit = nullptr,
          .budget = {},
          .white = kWhite,
          .unseen_variance = unseen_variance_from(kWhite),
          .reference_exposure = reference_exposure};
}

}  // namespace hdrcam::test
