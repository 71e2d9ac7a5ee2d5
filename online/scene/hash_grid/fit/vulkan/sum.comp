#version 450
#extension GL_GOOGLE_include_directive : require
// Adds up the chunks of outer.comp, in their order. One invocation per vector of four parameters.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants { int parameters, chunks; };
layout(std430, set = 0, binding = 0) readonly buffer Sums { vec4 sums[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Gradient { vec4 gradient[]; };

void main() {
  const int i = column();
  if (i >= parameters) return;
  vec4 sum = vec4(0);
  for (int chunk = 0; chunk < chunks; ++chunk) sum += sums[chunk * parameters + i];
  gradient[i] = sum;
}
