#version 450
#extension GL_GOOGLE_include_directive : require
// The difference of the pictures along the flow, and its derivatives.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
};
READS(0, Level, level)
READS(1, Flow, flow)
WRITES(2, Data, data)
#include "online/priors/motion/vulkan/flow.glsl"
#include "online/priors/motion/vulkan/refinement.glsl"

void main() {
  const int x = column(), y = row(), direction = plane(), u = kVectorPlanes * direction;
  if (x >= cols) return;
  const vec2 by = vec2(flow[at(u, y, x)], flow[at(u + 1, y, x)]);
  const vec2 place = clamped(vec2(x, y) + by, vec2(0), vec2(cols, rows) - 1.001);
  const ivec2 whole = ivec2(place);
  const vec2 f = place - vec2(whole);
  const int to = at(other_plane(direction), whole.y, whole.x), from = at(own_plane(direction), y, x);
  for (int k = 0; k < kPicturePlanes; ++k) {
    const int p = to + k * rows * cols;
    const float above = mix(level[p], level[p + 1], f.x);
    const float below = mix(level[p + cols], level[p + cols + 1], f.x);
    const float moved = mix(above, below, f.y);
    const float own = level[from + k * rows * cols];
    data[at(kDataPlanes * direction + k, y, x)] = k == 0 ? moved - own : 0.5 * (moved + own);
  }
}
