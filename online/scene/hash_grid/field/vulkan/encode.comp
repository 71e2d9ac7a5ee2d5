#version 450
#extension GL_GOOGLE_include_directive : require
// Features of one level of a hash grid (../hash_grid.h) at each sample: trilinear interpolation of its table.
// One invocation per sample and level.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int first, count, ld, slot, level_size;  // samples first .. first + count - 1; slot: -1, each its own
};
READS(0, Positions, position)  // u, v, d, and where it is asked for the slot [ld]
layout(std430, set = 0, binding = 1) readonly buffer Table { vec2 table[]; };
WRITES(2, Features, features)
layout(std140, set = 0, binding = 3) uniform Levels { uvec4 levels[32]; };
#include "online/scene/hash_grid/field/vulkan/corners.glsl"

void main() {
  const int s = first + column(), l = plane();
  if (column() >= count) return;
  const Corners at = corners_at(l, vec3(position[s], position[ld + s], position[2 * ld + s]));
  const uint table_slot = slot < 0 ? uint(position[3 * ld + s]) : uint(slot);
  vec2 sum = vec2(0);
  for (int corner = 0; corner < 8; ++corner)
    sum += weight_of(at, corner) * table[uint(l * level_size) + entry_of(at, corner, table_slot)];
  features[2 * l * ld + s] = sum.x;
  features[(2 * l + 1) * ld + s] = sum.y;
}
