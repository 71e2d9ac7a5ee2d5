// The hot loops of shrinkage.h on raw pointers: one table of functions per instruction set, picked at start
// by shrinkage_kernels(). Reentrant. Declarations only: the kernels' file may include nothing with inline
// code (CMakeLists.txt).
#pragma once

#include "render/shrinkage_constants.h"

namespace hdrcam {

// The logarithm of radiance + offset in opponent colours, and its variance: three planes' rows.
struct OpponentRow {
  const float *radiance[3], *variance[3];
  float offset;
  float *opponent[3], *noise[3];
  float *sum[3], *weight[3];  // are cleared
};

// One row of tiles of one channel. The pointers stand at its first pixel, rows are `cols` floats long.
struct TileRow {
  const float *opponent, *noise;
  const float* thresholds;  // of the tile's coefficients, by both frequencies alike, per variance of a pixel
  int first;                // column of the first tile; the last one ends with the row
  int cols;
  float *sum, *weight;  // each tile is added
};

// What the tiles add up to, as radiance: three planes' rows.
struct SmoothRow {
  const float *sum[3], *weight[3];
  float offset;
  float* radiance[3];
};

struct ShrinkageKernels {
  void (*to_opponent)(const OpponentRow&, int n);
  void (*shrink)(const TileRow&);
  void (*to_radiance)(const SmoothRow&, int n);
};

const ShrinkageKernels& shrinkage_kernels();

}  // namespace hdrcam
