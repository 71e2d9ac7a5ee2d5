#version 450
#extension GL_GOOGLE_include_directive : require
// The largest of each pixel and its left, upper and upper left neighbours (online/state/look_ahead.cpp).
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
};
READS(0, Source, source)
WRITES(1, Largest, largest)
#include "online/pictures/vulkan/picture.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane(), left = max(0, x - 1), up = max(0, y - 1);
  largest[at(c, y, x)] = max(max(source[at(c, y, x)], source[at(c, y, left)]),
                             max(source[at(c, up, x)], source[at(c, up, left)]));
}
