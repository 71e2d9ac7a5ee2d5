#version 450
#extension GL_GOOGLE_include_directive : require
// Features of one level of a hash grid (../hash_grid.h) at each sample: trilinear interpolation of its table.
// One invocation per sample and level.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int count, ld, slot, level_size;
};
READS(0, Positions, position)
layout(std430, set = 0, binding = 1) readonly buffer Table { vec2 table[]; };
WRITES(2, Features, features)
// HashLevel: cells along u, v, d and dense or not; strides and entries.
layout(std140, set = 0, binding = 3) uniform Levels { uvec4 levels[32]; };

void main() {
  const int s = column(), l = plane();
  if (s >= count) return;
  const uvec4 lattice = levels[2 * l], strides = levels[2 * l + 1];
  const uint entries = strides.w;
  const bool dense = lattice.w != 0;
  uint low[3], high[3];
  float fraction[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float cells = uintBitsToFloat(lattice[axis]);
    const float x = max(0.0, min(position[axis * ld + s] * cells, cells * 0.999999));
    const uint vertex = uint(x), stride = strides[axis];
    fraction[axis] = x - float(vertex);
    low[axis] = vertex * stride, high[axis] = low[axis] + stride;
  }
  vec2 sum = vec2(0);
  for (int corner = 0; corner < 8; ++corner) {
    const bool u = (corner & 1) != 0, v = (corner & 2) != 0, d = (corner & 4) != 0;
    const uint a = u ? high[0] : low[0], b = v ? high[1] : low[1], c = d ? high[2] : low[2];
    const uint entry = (dense ? a + b + c : (a ^ b ^ c) & (entries - 1)) + uint(slot) * entries;
    const float weight = (u ? fraction[0] : 1 - fraction[0]) * (v ? fraction[1] : 1 - fraction[1]) *
                         (d ? fraction[2] : 1 - fraction[2]);
    sum += weight * table[uint(l * level_size) + entry];
  }
  features[2 * l * ld + s] = sum.x;
  features[(2 * l + 1) * ld + s] = sum.y;
}
