#version 450
#extension GL_GOOGLE_include_directive : require
// Mean and variance over 3x3 pixels, mirrored at the border.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
};
READS(0, Source, source)
WRITES(1, Mean, mean)
WRITES(2, Variance, variance)
#include "online/pictures/vulkan/picture.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  float sum = 0, squares = 0;
  for (int j = -1; j <= 1; ++j) {
    const int line = at(c, mirrored(y + j, rows), 0);
    for (int i = -1; i <= 1; ++i) {
      const float v = source[line + mirrored(x + i, cols)];
      sum += v, squares += v * v;
    }
  }
  const float m = sum / 9;
  mean[at(c, y, x)] = m;
  variance[at(c, y, x)] = max(0.0, squares / 9 - m * m);
}
