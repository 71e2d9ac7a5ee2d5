// What this processor can do at most, for comparison with the kernels (kernel_rates.h): one table of
// functions per instruction set, picked at start by ceiling_kernels(). Reentrant. Declarations only: the
// kernels' file may include nothing with inline code (CMakeLists.txt).
#pragma once

namespace hdrcam {

struct CeilingKernels {
  // Multiply-adds in registers alone; returns something that depends on all of them.
  float (*multiply_add)(int rounds);
  int flops_per_round;
  // out = a + 0.5 b, n a multiple of 16: two streams are read, one is written
  void (*stream)(const float* a, const float* b, float* out, int n);
  // The sum of the pairs of floats at these places of a table, n a multiple of 8: as a hash grid is read.
  float (*look_up)(const float* table, const int* place, int n);
};

const CeilingKernels& ceiling_kernels();

}  // namespace hdrcam
