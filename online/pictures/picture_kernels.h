// The hot loops over pictures on raw pointers: one table of functions per instruction set, picked at start by
// picture_kernels(). Planes are contiguous rows of `cols` floats. Reentrant. Declarations only: the kernels'
// file may include nothing with inline code (CMakeLists.txt).
#pragma once

#include <cstddef>

namespace hdrcam {

// One band of rows of a picture moved along a flow (warp.h).
struct WarpBand {
  const float* in = nullptr;                 // [channels, rows, cols]
  float* out = nullptr;                      // the same
  const float *dx = nullptr, *dy = nullptr;  // [rows, cols] pixels
  int channels = 0, rows = 0, cols = 0;
  int y0 = 0, y1 = 0;  // the rows of `out` to be written
  float limit = 0;     // of the cubic against the bilinear value, up and down; 0: none
  // of warp_cubic: becomes the largest of the four pixels around each place, as `out`; null: not wanted
  float* largest = nullptr;
  // of warp_cubic: what `in` is the logarithm of (log_radiance), as `in`; `out` then becomes radiance, too.
  // Null: `in` is what it is.
  const float* radiance = nullptr;
};

// A run of samples: ln(radiance + kDarkRadiance), radiance below 0 as 0.
struct LogRadiance {
  const float* radiance;
  float* logarithm;
  std::size_t count;
};
inline constexpr float kDarkRadiance = 2e-4f;  // of white at the reference exposure

// One row of a small-window statistic (local_statistics.h) of a plane.
struct WindowRow {
  const float* line[5];  // the rows that are looked at, 2 radius + 1, from above to below
  int cols;
  int radius;              // 1 or 2
  float *mean, *variance;  // of the row amid them; variance: of radius 1 only, null for the mean alone
};

struct PictureKernels {
  void (*warp_linear)(const WarpBand&);
  void (*warp_cubic)(const WarpBand&);
  void (*log_radiance)(const LogRadiance&);
  void (*window)(const WindowRow&);
};

const PictureKernels& picture_kernels();

}  // namespace hdrcam
