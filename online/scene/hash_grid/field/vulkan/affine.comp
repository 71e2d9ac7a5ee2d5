#version 450
#extension GL_GOOGLE_include_directive : require
// One layer of a network (../mlp.h): y = W x + b, negative values set to zero where it is rectified. One
// invocation per sample and four outputs.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int count, ld, first, inputs, outputs, rectified;
};
READS(0, Parameters, parameter)
READS(1, Inputs, x)
WRITES(2, Outputs, y)

void main() {
  const int s = column(), o = 4 * row();
  if (s >= count) return;
  const int bias = first + inputs * outputs + o;
  vec4 sum = vec4(parameter[bias], parameter[bias + 1], parameter[bias + 2], parameter[bias + 3]);
  int w = first + o * inputs;
  for (int i = 0; i < inputs; ++i, ++w)
    sum += x[i * ld + s] *
           vec4(parameter[w], parameter[w + inputs], parameter[w + 2 * inputs], parameter[w + 3 * inputs]);
  if (rectified != 0) sum = max(sum, vec4(0));
  for (int k = 0; k < 4; ++k) y[(o + k) * ld + s] = sum[k];
}
