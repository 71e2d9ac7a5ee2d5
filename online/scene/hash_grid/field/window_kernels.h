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
  float unseen;  // variance from which on a pixel counts as unseen
  float trusted_sigma;
  float *log_radiance, *gate;
};

// A flow of pixels, lifted to the surfaces at both of its ends.
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

struct WindowKernels {
  void (*values)(const ValueRow&, int n);
  void (*base)(const BaseRow&, int n);
  void (*lift)(const LiftedRow&, int n);
};

const WindowKernels& window_kernels();

}  // namespace hdrcam
