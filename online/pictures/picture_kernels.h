// The hot loops over pictures on raw pointers: one table of functions per instruction set, picked at start by
// picture_kernels(). Planes are contiguous rows of `cols` floats. Reentrant. Declarations only: the kernels'
// file may include nothing with inline code (CMakeLists.txt).
#pragma once

#include <cstddef>

namespace hdrcam {

// One band of rows of a picture moved along a flow (warp.h).
struct WarpBand {
  const float* in;       // [channels, rows, cols]
  float* out;            // the same
  const float *dx, *dy;  // [rows, cols] pixels
  int channels, rows, cols;
  int y0, y1;   // the rows of `out` to be written
  float limit;  // of the cubic against the bilinear value; 0: none
  // of warp_cubic: becomes the largest of the four pixels around each place, as `out`; null: not wanted
  float* largest = nullptr;
};

// One row of a small-window statistic (local_statistics.h) of a plane.
struct WindowRow {
  const float* line[5];  // the rows that are looked at, 2 radius + 1, from above to below
  int cols;
  int radius;              // 1 or 2
  float *mean, *variance;  // of the row amid them; variance: null for the mean alone
};

struct PictureKernels {
  void (*warp_linear)(const WarpBand&);
  void (*warp_cubic)(const WarpBand&);
  void (*window)(const WindowRow&);
};

const PictureKernels& picture_kernels();

}  // namespace hdrcam
