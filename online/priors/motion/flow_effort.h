// How much a quality of flow does, and at which scales: alike wherever the flow runs. Scale s is the picture
// halved s times. Reentrant.
#pragma once

#include "online/priors/motion/flow_kernels.h"
#include "online/priors/motion/motion_prior.h"

namespace hdrcam {

struct FlowEffort {
  int finest_scale;    // 0: full size, 1: half, 2: a quarter
  int stride;          // pixels between patches
  int steps;           // of descent, in each of the two sweeps
  int rounds, sweeps;  // of the refinement
};
FlowEffort effort_of(FlowQuality quality);

// Of pictures of rows x cols pixels.
struct FlowScales {
  int coarsest;  // its shorter side is about two patches long
  int finest;    // of an effort, or the coarsest where that is finer
  // At which what is not explained is looked for far away: the finest at which comparing a patch with a third
  // of the picture costs little, and objects still have patches of their own.
  int far;
};
FlowScales scales_of(const FlowEffort& effort, int rows, int cols);

PatchGrid patch_grid(int rows, int cols, int stride);

// How far a patch is looked for far away, along a side of so many pixels.
int far_reach(int side);

}  // namespace hdrcam
