#version 450
#extension GL_GOOGLE_include_directive : require
// A picture moved along a motion [dx, dy, ..]: the first `cubic_planes` planes by cubic convolution, within `limit` of the
// bilinear value, the others bilinearly.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, cubic_planes;
  float limit;
};
READS(0, Source, source)
READS(1, Motion, motion)
WRITES(2, Moved, moved)
#include "online/pictures/vulkan/picture.glsl"
#include "online/pictures/vulkan/interpolate.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  const ivec4 place = split_position(float(x) + motion[at(0, y, x)], float(y) + motion[at(1, y, x)]);
  moved[at(c, y, x)] = c < cubic_planes ? cubic_at(c, place, limit) : linear_at(c, place);
}
