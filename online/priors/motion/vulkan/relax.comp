#version 450
#extension GL_GOOGLE_include_directive : require
// Half a sweep of the solver, over the even or over the odd rows: neighbours in the row as they were, those
// above and below as they are now. What was (`flow`) and what becomes (`next`) lie apart; after the odd half
// all rows are in `next`.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, odd;
};
READS(0, System, system)
READS(1, Flow, flow)
CHANGES(2, Next, next)
// flow.glsl reads a `level`; here only its at() is used.
#define level system
#include "online/priors/motion/vulkan/flow.glsl"
#include "online/priors/motion/vulkan/refinement.glsl"

int u_plane, system_plane;

float of_system(int k, int y, int x) { return system[at(system_plane + k, y, x)]; }
float link_at(int y, int x) { return of_system(5, y, x); }
vec2 was_at(int y, int x) { return vec2(flow[at(u_plane, y, x)], flow[at(u_plane + 1, y, x)]); }
vec2 is_at(int y, int x) {
  return odd != 0 ? vec2(next[at(u_plane, y, x)], next[at(u_plane + 1, y, x)]) : was_at(y, x);
}

void main() {
  const int x = column(), y = 2 * row() + odd, direction = plane();
  if (x >= cols || y >= rows) return;
  u_plane = kVectorPlanes * direction, system_plane = kSystemPlanes * direction;
  const float own = link_at(y, x);
  vec2 sum = vec2(0);
  if (x > 0) sum += link_at(y, x - 1) * was_at(y, x - 1);
  if (x + 1 < cols) sum += own * was_at(y, x + 1);
  if (y > 0) sum += link_at(y - 1, x) * is_at(y - 1, x);
  if (y + 1 < rows) sum += own * is_at(y + 1, x);
  const vec2 old = was_at(y, x);
  const float a = of_system(0, y, x);
  const float u = (sum.x + of_system(1, y, x) - a * old.y) * of_system(3, y, x);
  const float v = (sum.y + of_system(2, y, x) - a * u) * of_system(4, y, x);
  next[at(u_plane, y, x)] = old.x + kRelaxed * (u - old.x);
  next[at(u_plane + 1, y, x)] = old.y + kRelaxed * (v - old.y);
}
