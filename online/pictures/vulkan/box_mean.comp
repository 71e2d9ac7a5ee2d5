#version 450
#extension GL_GOOGLE_include_directive : require
// Mean over (2 radius + 1)^2 pixels, mirrored at the border.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, radius;
};
READS(0, Source, source)
WRITES(1, Mean, mean)
#include "online/pictures/vulkan/picture.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  float sum = 0;
  for (int j = -radius; j <= radius; ++j) {
    const int line = at(c, mirrored(y + j, rows), 0);
    for (int i = -radius; i <= radius; ++i) sum += source[line + mirrored(x + i, cols)];
  }
  mean[at(c, y, x)] = sum / float((2 * radius + 1) * (2 * radius + 1));
}
