#version 450
#extension GL_GOOGLE_include_directive : require
// Adam on the entries of a table that scatter.comp has touched; clears their gradient. One invocation per
// entry, slot and level.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  float rate, gradient_scale, beta1, beta2, epsilon;
  int entries, level_size, count_bits;  // entries: of a slot
};
layout(std430, set = 0, binding = 0) buffer Table { vec2 table[]; };
layout(std430, set = 0, binding = 1) buffer TableGradient { uvec4 d_table[]; };
layout(std430, set = 0, binding = 2) buffer Mean { vec2 mean[]; };
layout(std430, set = 0, binding = 3) buffer Variance { vec2 variance[]; };
layout(std430, set = 0, binding = 4) readonly buffer Peak { uint peak[]; };
#include "online/scene/hash_grid/fit/vulkan/adam.glsl"
#include "online/scene/hash_grid/fit/vulkan/fixed_point.glsl"

void main() {
  const int l = plane();
  if (column() >= entries) return;
  const int at = l * level_size + row() * entries + column();
  const uvec4 words = d_table[at];
  if (words == uvec4(0)) return;
  const int bits = low_bits(count_bits);
  const float unit = unit_of(peak[l], count_bits);
  vec2 moved = table[at], m = mean[at], v = variance[at];
  adam(units_of(words.x, words.y, bits) * unit, moved.x, m.x, v.x);
  adam(units_of(words.z, words.w, bits) * unit, moved.y, m.y, v.y);
  table[at] = moved, mean[at] = m, variance[at] = v;
  d_table[at] = uvec4(0);
}
