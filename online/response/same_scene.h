// Whether two pictures of different exposure show one scene, or a cut lies between them. Whatever lies
// between the exposures and whatever the response, two pictures of one scene agree in the medians of 16x16
// cells of green up to a monotone curve, so Spearman's rank correlation of these is compared with a limit.
// Reentrant.
#pragma once

#include "capture/exposed_frame.h"

namespace hdrcam {

// Both of one size, unpacked without a black level. True also where too few cells are clipped in neither
// picture to tell.
bool shows_one_scene(const ExposedFrame& a, const ExposedFrame& b);

}  // namespace hdrcam
