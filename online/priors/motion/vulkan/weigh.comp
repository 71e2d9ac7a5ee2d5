#version 450
#extension GL_GOOGLE_include_directive : require
// The equations of each pixel's flow, (a11 + w) u + a12 v = c1 + sum of linked u, and so for v, weighed by how
// well the flow so far explains the pictures, and linked less where it changes; w is the sum of the links.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
};
READS(0, Data, data)
READS(1, Before, before)
READS(2, Flow, flow)
WRITES(3, System, system)
// flow.glsl reads a `level`; here only its at() is used.
#define level data
#include "online/priors/motion/vulkan/flow.glsl"
#include "online/priors/motion/vulkan/refinement.glsl"

int u_plane;

vec2 flow_at(int y, int x) { return vec2(flow[at(u_plane, y, x)], flow[at(u_plane + 1, y, x)]); }

// What ties a pixel to its right and lower neighbour.
float link_at(int y, int x) {
  const vec2 here = flow_at(y, x);
  const vec2 right = flow_at(y, min(x + 1, cols - 1)) - here, below = flow_at(min(y + 1, rows - 1), x) - here;
  return inversesqrt(dot(right, right) + dot(below, below) + kSmallest * kSmallest);
}

void main() {
  const int x = column(), y = row(), direction = plane();
  if (x >= cols) return;
  u_plane = kVectorPlanes * direction;
  const int first = kDataPlanes * direction, out_plane = kSystemPlanes * direction;
  const float gt = data[at(first, y, x)];
  const vec2 g = vec2(data[at(first + 1, y, x)], data[at(first + 2, y, x)]);
  const vec2 at_flow = vec2(before[at(u_plane, y, x)], before[at(u_plane + 1, y, x)]);
  const float rest = gt + dot(g, flow_at(y, x) - at_flow);
  const float size = dot(g, g) + kLeastSlope2;
  const float w = kPictures * inversesqrt(size * (rest * rest + kLeastDistance2 * size));
  const float pull = w * (dot(g, at_flow) - gt), own = link_at(y, x);
  const float links = (x > 0 ? link_at(y, x - 1) : 0) + (x + 1 < cols ? own : 0) +
                      (y > 0 ? link_at(y - 1, x) : 0) + (y + 1 < rows ? own : 0);
  system[at(out_plane, y, x)] = w * g.x * g.y;
  system[at(out_plane + 1, y, x)] = g.x * pull;
  system[at(out_plane + 2, y, x)] = g.y * pull;
  system[at(out_plane + 3, y, x)] = 1 / (w * g.x * g.x + links);
  system[at(out_plane + 4, y, x)] = 1 / (w * g.y * g.y + links);
  system[at(out_plane + 5, y, x)] = own;
}
