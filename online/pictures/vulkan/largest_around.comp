#version 450
#extension GL_GOOGLE_include_directive : require
// The largest of the four pixels around each place that a motion [dx, dy, ..] leads to, of each plane.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
};
READS(0, Source, source)
READS(1, Motion, motion)
WRITES(2, Largest, largest)
#include "online/pictures/vulkan/picture.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  const ivec4 place = split_position(float(x) + motion[at(0, y, x)], float(y) + motion[at(1, y, x)]);
  const int above = clamp(place.y, 0, rows - 1), below = clamp(place.y + 1, 0, rows - 1);
  const int left = clamp(place.x, 0, cols - 1), right = clamp(place.x + 1, 0, cols - 1);
  largest[at(c, y, x)] = max(max(source[at(c, above, left)], source[at(c, above, right)]),
                             max(source[at(c, below, left)], source[at(c, below, right)]));
}
