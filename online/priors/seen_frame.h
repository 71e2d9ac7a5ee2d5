// The input of the priors of pose and depth: a frame, the state including it, and the motion from the
// previous frame. Borrowed for the call. Plain value.
#pragma once

#include "capture/exposed_frame.h"
#include "online/pictures/flow_field.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

struct SeenFrame {
  const ExposedFrame& frame;
  const RadianceState& state;
  const StateMotion& motion;  // empty at the first frame
};

}  // namespace hdrcam
