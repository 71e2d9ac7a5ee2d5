#version 450
#extension GL_GOOGLE_include_directive : require
// The gradient of the displaced samples' places, by their features (position_backward() of
// ../../field/hash_grid.h) and as composite_backward.comp has found it, is that of the scene flow that
// displaced them. One invocation per sample.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  vec3 unit;  // window units per unit of flow
  int count, samples, ld, levels_used, level_size;  // samples: per ray
  int d_place, plane_of_flow;                       // first planes in d_raw
};
layout(std430, set = 0, binding = 0) readonly buffer Rays { vec4 told[]; };
READS(1, Placed, placed)
layout(std430, set = 0, binding = 2) readonly buffer Table { vec2 table[]; };
READS(3, FeatureGradient, d_features)
CHANGES(4, RawGradient, d_raw)
layout(std140, set = 0, binding = 5) uniform Levels { uvec4 levels[32]; };
#include "online/scene/hash_grid/field/vulkan/corners.glsl"

// The slope of a level's features, weighted by their gradients.
vec3 slope(int level, vec3 point, uint slot, vec2 d_feature) {
  const Corners at = corners_at(level, point);
  vec3 sum = vec3(0);
  for (int corner = 0; corner < 8; ++corner) {
    const vec3 w = mix(1 - at.fraction, at.fraction, is_far(corner));
    const vec3 sign = mix(vec3(-1), vec3(1), is_far(corner));
    const float value = dot(d_feature, table[uint(level * level_size) + entry_of(at, corner, slot)]);
    sum += value * sign * vec3(w.y * w.z, w.x * w.z, w.x * w.y);
  }
  return sum * at.cells * at.inside;
}

void main() {
  const int s = column(), moved = count + s;
  if (s >= count) return;
  const vec4 aim = told[5 * (s / samples) + 4];
  if (aim.x < 0) return;
  const vec3 point = vec3(placed[moved], placed[ld + moved], placed[2 * ld + moved]);
  const uint slot = uint(placed[3 * ld + moved]);
  vec3 d = vec3(d_raw[d_place * ld + s], d_raw[(d_place + 1) * ld + s], d_raw[(d_place + 2) * ld + s]);
  for (int level = 0; level < levels_used; ++level)
    d += slope(level, point, slot,
               vec2(d_features[2 * level * ld + moved], d_features[(2 * level + 1) * ld + moved]));
  for (int a = 0; a < 3; ++a) d_raw[(plane_of_flow + 3 * int(aim.y) + a) * ld + s] += d[a] * unit[a];
}
