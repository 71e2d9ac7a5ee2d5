#version 450
#extension GL_GOOGLE_include_directive : require
// ln(radiance + dark) of the first planes; the others are copied.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, radiance_planes;
  float dark;
};
READS(0, State, state)
WRITES(1, Logs, logs)
#include "online/pictures/vulkan/picture.glsl"

void main() {
  if (!is_pixel()) return;
  const int i = at(plane(), row(), column());
  logs[i] = plane() < radiance_planes ? log(max(0, state[i]) + dark) : state[i];
}
