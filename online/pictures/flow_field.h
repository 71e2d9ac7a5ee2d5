// Dense motion between two pictures of one size: for each pixel of the first, where it is in the second.
// vectors: [dx dy, rows, cols] pixels; confidence: [1, rows, cols] 0..1 (forward-backward agreement, inside
// the frame). Move-only values.
#pragma once

#include "hal/core/image.h"

namespace hdrcam {

struct FlowField {
  Image<float> vectors;
  Image<float> confidence;

  bool empty() const { return vectors.empty(); }
};

// Of the flow, at least: what is measured by comparing pixels along it takes no others.
inline constexpr float kComparedConfidence = 0.8f;

// Flow between the state at frame i-1 and frame i; both empty at the first frame.
struct StateMotion {
  FlowField to_previous;    // frame -> state
  FlowField from_previous;  // state -> frame
};

// A frame's neighbours, in the order of flow[2] and similar arrays.
enum class Neighbour : int { Next = 0, Previous = 1 };
constexpr int neighbour_of(int frame, Neighbour which) {
  return which == Neighbour::Next ? frame + 1 : frame - 1;
}

}  // namespace hdrcam
