#version 450
#extension GL_GOOGLE_include_directive : require
// The next coarser scale of both pictures: means of 2 x 2. A last odd row or column is left out.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, finer_rows, finer_cols;
};
READS(0, Finer, finer)
CHANGES(1, Level, level)
#include "online/priors/motion/vulkan/flow.glsl"

void main() {
  const int x = column(), y = row(), gray = own_plane(plane());
  if (x >= cols) return;
  const int above = (gray * finer_rows + 2 * y) * finer_cols + 2 * x, below = above + finer_cols;
  level[at(gray, y, x)] = 0.25 * ((finer[above] + finer[above + 1]) + (finer[below] + finer[below + 1]));
}
