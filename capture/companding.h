// Companding: the codes of a linear camera become their square roots, before the fit sees them. What is near
// black is told apart in codes, whose steps are meant to be even to the eye, as those of pictures are; linear
// codes are much finer there, and by the same limits most of what they tell would be taken for nothing.
// Reentrant.
#pragma once

#include "capture/exposed_frame.h"

namespace hdrcam {

// A code z becomes 255 (z / 255)^(1 / kCompanding), whose response is Response::gamma(kCompanding).
inline constexpr float kCompanding = 2;

inline bool is_companded(const CameraFacts& camera) { return camera.linear; }

// Once per frame, after its black level is removed.
void compand(ExposedFrame& frame);

}  // namespace hdrcam
