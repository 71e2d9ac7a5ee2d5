#version 450
#extension GL_GOOGLE_include_directive : require
// Adds the gradient of each sample's features to the eight entries of a table that they came from, as whole
// numbers (fixed_point.glsl). One invocation per sample and level.
//   d_table  [levels][entries][high, low word of each feature]
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int count, ld, slot, level_size, count_bits;  // slot: -1, each its own
};
READS(0, Positions, position)
READS(1, FeatureGradient, d_features)
layout(std430, set = 0, binding = 2) readonly buffer Peak { uint peak[]; };
layout(std430, set = 0, binding = 3) buffer TableGradient { uint d_table[]; };
layout(std140, set = 0, binding = 4) uniform Levels { uvec4 levels[32]; };
#include "online/scene/hash_grid/field/vulkan/corners.glsl"
#include "online/scene/hash_grid/fit/vulkan/fixed_point.glsl"

void main() {
  const int s = column(), l = plane();
  if (s >= count || peak[l] == 0) return;
  const vec2 d =
      vec2(d_features[2 * l * ld + s], d_features[(2 * l + 1) * ld + s]) * units_per_one(peak[l], count_bits);
  if (d == vec2(0)) return;
  const Corners at = corners_at(l, vec3(position[s], position[ld + s], position[2 * ld + s]));
  const uint table_slot = slot < 0 ? uint(position[3 * ld + s]) : uint(slot);
  const int bits = low_bits(count_bits);
  for (int corner = 0; corner < 8; ++corner) {
    const uint to = 4 * (uint(l * level_size) + entry_of(at, corner, table_slot));
    const float weight = weight_of(at, corner);
    for (uint f = 0; f < 2; ++f) {
      const Words term = words_of(weight * d[f], bits);
      atomicAdd(d_table[to + 2 * f], term.high);
      atomicAdd(d_table[to + 2 * f + 1], term.low);
    }
  }
}
