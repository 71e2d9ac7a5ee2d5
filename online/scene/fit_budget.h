// The budget of a field's fit on one frame, passed with each call, so that a governor can change it. A field
// uses the members that apply to it: one without rays ignores the rays. Plain value.
#pragma once

namespace hdrcam {

struct FitBudget {
  int steps = 30;           // 0..1000 optimiser steps after the frame; time grows in proportion
  int rays_per_step = 256;  // 32..4096, a multiple of 32: many small steps beat few large ones on a CPU
  int samples_per_ray = 8;  // 1..16 where the camera moves and depth is observable; a view costs as many
  int samples_without_parallax = 2;  // 1..16 where depth is not observable: two layers suffice
  int interval = 1;                  // 1..64 frames: steps are taken at each n-th, from the first on
};

}  // namespace hdrcam
