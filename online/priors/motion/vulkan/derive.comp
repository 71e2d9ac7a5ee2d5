#version 450
#extension GL_GOOGLE_include_directive : require
// Sobel derivatives of both pictures, whose edges go on.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
};
CHANGES(0, Level, level)
#include "online/priors/motion/vulkan/flow.glsl"

void main() {
  const int x = column(), y = row(), gray = own_plane(plane());
  if (x >= cols) return;
  float around[9];
  for (int k = 0; k < 9; ++k) around[k] = near(gray, y + k / 3 - 1, x + k % 3 - 1);
  level[at(gray + 1, y, x)] =
      ((around[2] - around[0]) + 2 * (around[5] - around[3]) + (around[8] - around[6])) * 0.125;
  level[at(gray + 2, y, x)] =
      ((around[6] - around[0]) + 2 * (around[7] - around[1]) + (around[8] - around[2])) * 0.125;
}
