// One value as the half float that files and pipes hold (IEEE 754 binary16); half_kernels.h does whole
// planes. Reentrant.
#pragma once

#include <Imath/half.h>

#include <algorithm>

namespace hdrcam {

inline constexpr float kLargestHalf = 65504;

// Nearest, ties to even; what is above the largest becomes the largest.
inline Imath::half as_half(float value) { return Imath::half(std::min(value, kLargestHalf)); }

}  // namespace hdrcam
