#version 450
#extension GL_GOOGLE_include_directive : require
// A path [dx dy, confidence] lengthened by one interval's motion of the same layout: flows are chained,
// confidences multiplied.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
};
READS(0, Motion, source)
READS(1, Path, path)
WRITES(2, Longer, longer)
#include "online/pictures/vulkan/picture.glsl"
#include "online/pictures/vulkan/interpolate.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row();
  const ivec4 place = split_position(float(x) + path[at(0, y, x)], float(y) + path[at(1, y, x)]);
  longer[at(0, y, x)] = path[at(0, y, x)] + linear_at(0, place);
  longer[at(1, y, x)] = path[at(1, y, x)] + linear_at(1, place);
  longer[at(2, y, x)] = path[at(2, y, x)] * linear_at(2, place);
}
