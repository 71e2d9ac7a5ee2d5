// A rigid transform as files and facts store it. geometry.h calculates with it. Plain value.
#pragma once

#include <array>

namespace hdrcam {

// Row-major 3x4, [R t].
using PoseMatrix = std::array<double, 12>;

}  // namespace hdrcam
