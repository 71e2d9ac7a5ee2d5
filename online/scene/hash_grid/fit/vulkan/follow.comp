#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Displaces samples along the scene flow of the dynamic branch, into the neighbour's slot (../ray_shard.h); one
// of a ray without a neighbour keeps its place. One invocation per sample.
#include "hal/gpu/element.glsl"
#include "online/scene/hash_grid/fit/vulkan/fit_constants.glsl"
layout(std430, set = 0, binding = 0) readonly buffer Rays { vec4 told[]; };
CHANGES(1, Placed, placed)
READS(2, Raw, raw)
// six of a frame, WindowOptions::kMostFrames frames
layout(std140, set = 0, binding = 3) uniform Views { vec4 views[84]; };
layout(std430, set = 0, binding = 4) readonly buffer BasePixels { vec4 base[]; };
#include "online/scene/hash_grid/fit/vulkan/ray.glsl"

void main() {
  const int s = column(), n = rays * samples;
  if (s >= n) return;
  const Ray ray = ray_at(s / samples);
  vec3 point = point_of(s);
  if (ray.warps) point += scene_flow(ray, s) * unit;
  for (int a = 0; a < 3; ++a) placed[a * ld + n + s] = point[a];
  placed[3 * ld + n + s] = ray.warps ? told[5 * (s / samples) + 4].z : placed[3 * ld + s];
}
