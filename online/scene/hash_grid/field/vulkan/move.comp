#version 450
#extension GL_GOOGLE_include_directive : require
// Where what a sample shows between two frames is at the nearest frame: one step of the fixed point
// x_frame = x - offset flow(x_frame), from x. One invocation per sample.
#include "hal/gpu/element.glsl"
#include "online/scene/hash_grid/field/vulkan/field_constants.glsl"
READS(0, Placed, placed)
READS(1, Dynamic, dynamic_raw)
layout(std140, set = 0, binding = 2) uniform Views { vec4 views[24]; };
layout(std430, set = 0, binding = 3) readonly buffer BasePixels { vec4 base[]; };
WRITES(4, Moved, moved)
#include "online/scene/hash_grid/field/vulkan/window.glsl"

void main() {
  const int s = column(), toward = offset > 0 ? 0 : 1;
  if (s >= rays * samples) return;
  const vec3 point = vec3(placed[s], placed[ld + s], placed[2 * ld + s]);
  const Base known = base_at(from_anchor(kFrame), point);
  for (int a = 0; a < 3; ++a) {
    const float flow = dynamic_raw[(4 + 3 * toward + a) * ld + s] + (a < 2 ? known.flow[2 * toward + a] : 0);
    moved[a * ld + s] = point[a] - abs(offset) * flow * unit[a];
  }
}
