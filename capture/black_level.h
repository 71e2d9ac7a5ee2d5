// The black level of a camera that reports none, from the pictures alone. Darkness maps to the black level B at every
// exposure, so B is the fixed point of the map from the codes of a long exposure to those of a short one; near it that
// map is a straight line for any power-like response. The darkest codes seen bound B from above. Reentrant.
#pragma once

#include <span>

#include "capture/unpack.h"

namespace hdrcam {

// frames: the first cycle or two, unpacked without a black level. Answers 0 where nothing speaks for more.
BlackLevel estimate_black_level(std::span<const ExposedFrame> frames);

}  // namespace hdrcam
