// The hot loops of dense flow on raw pointers: one table of functions per instruction set, picked at start by
// flow_kernels(). Pictures are planes of float with a border on all sides that repeats the edge, so that a
// patch that leaves the picture needs no test. Reentrant. Declarations only: the kernels' file may include
// nothing with inline code (CMakeLists.txt).
#pragma once

#include <cstddef>

#include "online/priors/motion/flow_constants.h"

namespace hdrcam {

using flow_constants::kNowhere;
using flow_constants::kPatchSize;
constexpr int kFlowBorder = flow_constants::kOutside + kPatchSize;  // pixels around each plane
constexpr int kLandingCell = 8;  // pixels, both ways, of a cell of landing.h
constexpr float kHome2 = 4;      // pixels^2: what ends farther off did not come home, there and back

// One scale of a pyramid. The pointers stand at pixel (0, 0); a row is `pitch` floats long.
struct FlowPicture {
  const float* gray;  // codes, 0..255
  const float* dx;    // derivative, codes per pixel
  const float* dy;
  std::ptrdiff_t pitch;
  int rows, cols;
};

// The places of the patches: every `stride` pixels, the last ones flush with the right and lower edge.
struct PatchGrid {
  int rows, cols;  // patches
  int stride;      // pixels
};

// Vectors of one scale, two planes without border.
struct FlowPlanes {
  float *u, *v;
};

struct PatchSearch {
  FlowPicture from, to;
  PatchGrid grid;
  FlowPlanes patches;  // [grid.rows, grid.cols]: in, the guess of each patch; out, what was found
  int steps;           // of descent, in each of the two sweeps
  // [grid.rows, grid.cols] each: the first guess, before `patches`, or null; one more, kNowhere for some, or
  // null
  const float *start_u = nullptr, *start_v = nullptr;
  const float *other_u = nullptr, *other_v = nullptr;
};

// How far from its place a patch is looked for, and where it was found: whole pixels, [grid.rows, grid.cols],
// kNowhere for patches that were not looked for or not found.
struct FarSearch {
  int reach_x, reach_y;  // pixels
  FlowPlanes found;
};

// A band of rows of a flow that is compared with the flow back, read at the pixel that it leads to. The
// confidence is exp(-|there and back|^2 / 2); 0 where a pixel leaves the picture.
struct RatedBand {
  const float *there, *back;  // [dx dy, rows, cols] pixels
  int rows, cols;
  int y0, y1;
  // [rgb, rows, cols] of the picture at the pixels, or null; where all channels are at `darkest` or below, or
  // at `brightest` or above, agreement means little, and the confidence is `assumed` at least
  const float* codes;
  float darkest, brightest, assumed;
  float* confidence;  // [rows, cols]
};

struct FlowKernels {
  // half-size picture: means of 2 x 2. Sizes are of `half`; a last odd row or column is left out.
  void (*halve)(const float* whole, std::ptrdiff_t pitch, int rows, int cols, float* half,
                std::ptrdiff_t half_pitch);
  // repeats the edge of a plane into its border
  void (*extend)(float* plane, std::ptrdiff_t pitch, int rows, int cols);
  // Sobel derivatives of a plane with its border filled; writes the picture only
  void (*derive)(const float* plane, std::ptrdiff_t pitch, int rows, int cols, float* dx, float* dy);
  // The inverse search of the patch rows [first, last): a sweep forward, which takes over neighbours' answers
  // from the left and above, and one back. Rows outside are neither read nor written.
  void (*search)(const PatchSearch&, int first, int last);
  // Of the patch rows [first, last): each that its answer does not explain is compared with every place
  // within reach. What moved farther than its own size is not found from coarse to fine: coarse pictures lack
  // it.
  void (*search_far)(const PatchSearch&, const FarSearch&, int first, int last);
  // Pixel rows [y0, y1) of the dense flow: the mean of the patches over each pixel, by how well each explains
  // it; `weight` is a plane for the sums
  void (*spread)(const PatchSearch&, int y0, int y1, FlowPlanes flow, float* weight);
  void (*rate)(const RatedBand&);
};

const FlowKernels& flow_kernels();

}  // namespace hdrcam
