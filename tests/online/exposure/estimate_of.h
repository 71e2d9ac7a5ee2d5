// What a frame's estimate tells those who choose exposures: its state and its motion, without a field.
#pragma once

#include "online/state/radiance_state.h"
#include "tests/support/state_estimate.h"

namespace hdrcam::test {

constexpr float kWhite = 16;

// All outlive the estimate; to_next: null where it is not known.
inline FrameEstimate estimate_of(const ExposedFrame& frame, const RadianceState& state,
                                 const FlowField& to_previous, const Image<float>* to_next,
                                 double reference_exposure) {
  FrameEstimate estimate = estimate_by_state(frame, state, state.own_share);
  estimate.to_previous = &to_previous, estimate.to_next = to_next;
  estimate.white = kWhite, estimate.unseen_variance = unseen_variance_from(kWhite);
  estimate.reference_exposure = reference_exposure;
  return estimate;
}

}  // namespace hdrcam::test
