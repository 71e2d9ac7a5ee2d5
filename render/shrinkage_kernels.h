// The hot loops of shrinkage.h on raw pointers: one table of functions per instruction set, picked at start
// by shrinkage_kernels(). Reentrant. Declarations only: the kernels' file may include nothing with inline
// code (CMakeLists.txt).
#pragma once

#include <cstddef>

#include "render/shrinkage_constants.h"

namespace hdrcam {

struct ShrinkageKernels {
  // The logarithm of radiance + offset in opponent colours, and its variance; sum and weight are cleared.
  // Each is three planes' rows of n pixels.
  void (*to_opponent)(const float* const radiance[3], const float* const variance[3], float offset, int n,
                      float* const opponent[3], float* const noise[3], float* const sum[3],
                      float* const weight[3]);
  // One row of tiles of one channel; the pointers stand at its first pixel, rows are `cols` floats long.
  // thresholds: of the tile's coefficients, by both frequencies alike, per variance of a pixel. first: the
  // column of the first tile; the last one ends with the row.
  void (*shrink)(const float* opponent, const float* noise, const float* thresholds, int first, int cols,
                 float* sum, float* weight);
  void (*to_radiance)(const float* const sum[3], const float* const weight[3], float offset, int n,
                      float* const radiance[3]);
};

const ShrinkageKernels& shrinkage_kernels();

}  // namespace hdrcam
