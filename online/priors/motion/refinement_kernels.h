// The refinement of a flow on raw pointers: one table of functions per instruction set, picked at start by
// refinement_kernels(). Reentrant. Declarations only: the kernels' file may include nothing with inline code
// that another object might share (CMakeLists.txt).
#pragma once

#include "online/priors/motion/flow_kernels.h"

namespace hdrcam {

constexpr int kRefinementPieces = 4;  // of the room that it works in

// Smooths a flow where the pictures allow it: robust brightness constancy against robust (total) variation.
struct FlowRefinement {
  FlowPicture from, to;
  FlowPlanes flow;                 // [rows, cols], refined in place
  float* room[kRefinementPieces];  // piece_floats(rows, cols) each
  float data;                      // weight of the pictures against that of smoothness
  float slope2;                    // (codes per pixel)^2 below which a difference says little of the motion
  float smallest;                  // pixels: differences of the flow below it cost as their square
  int rounds;                      // in which the weights are found anew
  int sweeps;                      // of the solver, in each round
};
struct RefinementKernels {
  std::ptrdiff_t (*piece_floats)(int rows, int cols);
  void (*refine)(const FlowRefinement&);
};

const RefinementKernels& refinement_kernels();

}  // namespace hdrcam
