// Companding: the codes of a linear camera become their square roots before the fit sees them. The fit tells
// dark codes apart by limits in codes of 255 (clip_policy.h, the noise of a code), which suit pictures: their
// steps are about even to the eye. Linear codes crowd the dark together: a thousandth of white is a quarter
// of a code, and by those limits nothing. Companded it is eight codes. Reentrant.
#pragma once

#include "capture/exposed_frame.h"

namespace hdrcam {

// A code z becomes 255 (z / 255)^(1 / kCompanding), whose response is Response::gamma(kCompanding).
inline constexpr float kCompanding = 2;

inline bool is_companded(const CameraFacts& camera) { return camera.linear; }

// Once per frame, after its black level is removed.
void compand(ExposedFrame& frame);

}  // namespace hdrcam
