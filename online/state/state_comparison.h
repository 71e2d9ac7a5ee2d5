// A frame and the state of the frame before it, to be compared where the motion between them is sure: what
// differs tells of the sensor. Borrowed for the call. Plain value.
#pragma once

#include "capture/exposed_frame.h"
#include "online/pictures/flow_field.h"
#include "online/state/exposure_tables.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

struct StateComparison {
  const ExposedFrame& frame;
  const RadianceState& state;
  const FlowField& to_previous;  // from the frame's pixels to the state's
  const ExposureTables& tables;  // at the frame's exposure
  float unseen_variance;         // from which on a pixel of the state counts as unseen
};

}  // namespace hdrcam
