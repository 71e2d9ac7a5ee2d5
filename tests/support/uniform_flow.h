// The motion of a picture in which every pixel moves alike, and surely. Reentrant.
#pragma once

#include <algorithm>

#include "online/pictures/flow_field.h"

namespace hdrcam::test {

// dx, dy: pixels.
inline FlowField uniform_flow(int rows, int cols, float dx = 0, float dy = 0) {
  FlowField flow{Image<float>(2, rows, cols), Image<float>(1, rows, cols)};
  std::fill_n(flow.vectors.plane(0), flow.vectors.plane_size(), dx);
  std::fill_n(flow.vectors.plane(1), flow.vectors.plane_size(), dy);
  flow.confidence.fill(1);
  return flow;
}

}  // namespace hdrcam::test
