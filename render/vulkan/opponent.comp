#version 450
#extension GL_GOOGLE_include_directive : require
// Radiance and its variance as logarithms in opponent colours: [value 3, variance 3].
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, tile_rows, tile_cols, line_step, shift;
  float offset, most_variance;
};
READS(0, Radiance, radiance)
READS(1, Variance, variance)
WRITES(2, Opponent, opponent)
#include "render/vulkan/tiles.glsl"

void main() {
  const int x = column(), y = row();
  if (x >= cols) return;
  vec3 value, noise;
  for (int c = 0; c < 3; ++c) {
    const float a = max(0.0, radiance[at(c, y, x)]) + offset;
    value[c] = log(a);
    noise[c] = min(most_variance, variance[at(c, y, x)] / (a * a));
  }
  for (int c = 0; c < 3; ++c) {
    opponent[at(c, y, x)] = dot(kOpponent[c], value);
    opponent[at(3 + c, y, x)] = dot(kOpponent[c] * kOpponent[c], noise);
  }
}
