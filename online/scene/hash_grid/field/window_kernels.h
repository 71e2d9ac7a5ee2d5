// The window's passes over whole pictures on raw pointers, a row of n pixels at a time: one table of
// functions per instruction set, picked at start by window_kernels(). window.h says what the values mean.
// Reentrant. Declarations only: the kernels' file may include nothing with inline code (CMakeLists.txt).
#pragma once

namespace hdrcam {

// One channel of a frame's codes.
struct ValueRow {
  const float* codes;
  float no_value;  // where the code is not a number
  float* values;   // codes / 255
};

// One channel of the state.
struct BaseRow {
  const float *radiance, *variance;
  float unseen_from;  // variance from which on a pixel counts as unseen
  float trusted_sigma;
  float *log_radiance, *gate;
};

// A flow of pixels, lifted: both of its ends lie at the inverse depth of its beginning, each in its own
// camera.
struct LiftedRow {
  const float *dx, *dy, *confidence;  // px
  const float* surface;               // inverse depth
  float x, y;                         // centre of the first pixel
  // rows of [R | t / near] of the cameras at the flow's beginning and end, to the anchor
  const float (*here)[4], (*there)[4];
  float focal[2], centre[2];  // px
  float nearest;              // z over the near distance, at least
  float most;                 // length of a flow along an axis, px
  float *u, *v;               // displacement in pixels of the anchor
  float* sure;                // confidence, 0..1
};

// Blocks of step x step pixels, side by side, in one channel of a picture. Past the picture's edges its last
// pixels repeat.
constexpr int kMostStep = 8, kMostBlocks = 64;
struct BlockRow {
  const float* row[kMostStep];  // each from the first pixel of the first block
  int step;                     // 1, 2, 4 or 8
  int cols;                     // pixels of a row up to the picture's edge or the end of the last block
};

// Codes of blocks. A block that is clipped altogether stays a bound. One that is clipped in part has no
// value: the mean of codes would be below the mean of the light, and would not say so.
struct ValueBlocks {
  BlockRow codes;
  float clipped;   // code from which on it is a bound
  float no_value;  // of a block with a code that is not a number, or clipped in part
  float* values;   // mean of codes / 255
};

// The state of blocks: light adds up, so the mean is of radiance, and its variance that of a mean of pixels
// whose errors are independent. With one unseen pixel it is the mean of bounds, a bound: unseen.
struct StateBlocks {
  BlockRow radiance, variance;
  float unseen_from;  // variance from which on a pixel counts as unseen
  float *mean, *variance_of_mean;
};

// The motion of blocks, the mean of their pixels' as far as it is believed: a pixel that lost its match does
// not lead its block away from where the others go.
struct FlowBlocks {
  BlockRow dx, dy, confidence;                    // px
  float *mean_dx, *mean_dy, *confidence_of_mean;  // in blocks; the mean of confidences
};

struct WindowKernels {
  void (*values)(const ValueRow&, int n);
  void (*base)(const BaseRow&, int n);
  void (*lift)(const LiftedRow&, int n);
  // n: 1..kMostBlocks
  void (*block_values)(const ValueBlocks&, int n);
  void (*block_state)(const StateBlocks&, int n);
  void (*block_flow)(const FlowBlocks&, int n);
};

const WindowKernels& window_kernels();

}  // namespace hdrcam
