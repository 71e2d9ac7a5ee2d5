// Half floats of a plane on raw pointers: one table of functions per instruction set, picked at start by
// half_kernels(). Reentrant. Declarations only: the kernels' file may include nothing with inline code
// (CMakeLists.txt).
#pragma once

#include <cstddef>
#include <cstdint>

namespace hdrcam {

struct HalfKernels {
  // n floats to the bits of the nearest half floats (IEEE 754 binary16, ties to even); beyond the largest
  // one, 65504, to that one. False where one is infinite or not a number: its bits mean nothing.
  bool (*to_half)(const float* values, std::size_t n, std::uint16_t* bits);
};

const HalfKernels& half_kernels();

}  // namespace hdrcam
