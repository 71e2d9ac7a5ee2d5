// What the fit of a field may spend on one frame. It enters with each call, so that a governor can move it
// from frame to frame. A field reads what it knows: one without rays leaves rays aside. Plain value.
#pragma once

namespace hdrcam {

struct FitBudget {
  int steps = 30;           // 0..1000 optimiser steps after the frame; time grows in proportion
  int rays_per_step = 256;  // 32..4096, a multiple of 32: many small steps beat few large ones on a CPU
  int samples_per_ray = 8;  // 1..16 where the camera moves and depth can be seen; also what a view costs
  int samples_without_parallax = 2;  // 1..16 where depth cannot be observed: two layers are all that matter
};

}  // namespace hdrcam
