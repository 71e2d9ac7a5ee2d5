// The two passes of demosaic.h over a row of n pixels: one table of functions per instruction set, picked at
// start by demosaic_kernels(). Columns and rows are mirrored at the border; codes of up to 16 bits come out
// the same on all. Reentrant. Declarations only: the kernels' file may include nothing with inline code
// (CMakeLists.txt).
#pragma once

#include <cstdint>

namespace hdrcam {

// Green of a row: the mosaic's, and where it has none, interpolated along the line with the smaller gradient.
struct GreenRow {
  const std::uint16_t* mosaic[5];  // from two rows above to two below
  int lacking;                     // the columns without green: even (0) or odd (1) ones
  float* green;
};

// Red or blue of a row, as smooth differences to green, which is there.
struct ColourRow {
  const std::uint16_t* mosaic[3];  // the row above, this one, the row below
  const float* green[3];
  bool is_in_row;  // whether this row of the mosaic has the colour; else those above and below
  int having;      // the columns that have it: even (0) or odd (1) ones
  float most, scale;
  float* out;  // clipped to 0 .. most, then scaled
};

struct DemosaicKernels {
  void (*green)(const GreenRow&, int n);
  void (*colour)(const ColourRow&, int n);
};

const DemosaicKernels& demosaic_kernels();

}  // namespace hdrcam
