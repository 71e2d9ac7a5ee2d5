#version 450
#extension GL_GOOGLE_include_directive : require
// A small network (../mlp.h): two rectified hidden layers and a linear head. One invocation per sample, which
// keeps its activations; weights are uniform, layer after layer in tiles [outputs / 4][1 + inputs][4 outputs],
// the biases first.
#include "hal/gpu/element.glsl"
#include "online/scene/hash_grid/field/branch_constants.h"
layout(push_constant) uniform Constants {
  int first, count, ld, inputs, hidden, outputs, plane_of_raw;  // samples first .. first + count - 1
};
READS(0, Features, features)
WRITES(1, Raw, raw)
layout(std140, set = 0, binding = 2) uniform Parameters { vec4 parameter[kMostParameters / 4]; };

float from[kMostWidth], to[kMostWidth];

// Returns the place of the next layer's parameters.
int layer(int first, int in_width, int out_width, float least) {
  for (int o = 0; o < out_width; o += 4) {
    vec4 sum = parameter[first];
    for (int i = 0; i < in_width; ++i) sum += parameter[first + 1 + i] * from[i];
    sum = max(sum, least);
    for (int k = 0; k < 4; ++k) to[o + k] = sum[k];
    first += 1 + in_width;
  }
  return first;
}

void main() {
  const int s = first + column();
  if (column() >= count) return;
  for (int i = 0; i < inputs; ++i) from[i] = features[i * ld + s];
  int at = layer(0, inputs, hidden, 0);
  for (int i = 0; i < hidden; ++i) from[i] = to[i];
  at = layer(at, hidden, hidden, 0);
  for (int i = 0; i < hidden; ++i) from[i] = to[i];
  layer(at, hidden, outputs, -3.4e38);
  for (int i = 0; i < outputs; ++i) raw[(plane_of_raw + i) * ld + s] = to[i];
}
