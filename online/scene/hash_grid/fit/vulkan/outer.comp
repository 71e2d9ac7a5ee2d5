#version 450
#extension GL_GOOGLE_include_directive : require
// The gradient of a network's parameters over some of the samples, in their order: the product of each layer's
// d_pre_activation and inputs (backward.comp). One invocation per tile of four outputs by four inputs, or
// their four biases, and chunk of samples.
//   sums  [chunks][parameters], in tiles as network.comp has them
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int count, per_chunk, inputs, hidden, outputs, parameters;  // vectors: of four neurons, of parameters
};
layout(std430, set = 0, binding = 0) readonly buffer Trace { vec4 trace[]; };
layout(std430, set = 0, binding = 1) readonly buffer PreActivationGradient { vec4 d_pre_activation[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Sums { vec4 sums[]; };

void main() {
  int tile = column();
  const int chunk = row(), in_stride = inputs + 2 * hidden, out_stride = 2 * hidden + outputs;
  int widths[4] = {inputs, hidden, hidden, outputs}, in_at = 0, out_at = 0, first = 0, layer = 0;
  for (; layer < 3; ++layer) {
    const int tiles = widths[layer + 1] * (1 + widths[layer]);
    if (tile < tiles) break;
    tile -= tiles;
    in_at += widths[layer], out_at += widths[layer + 1], first += widths[layer + 1] * (1 + 4 * widths[layer]);
  }
  if (layer == 3) return;
  const int in_width = widths[layer], o = tile / (1 + in_width), i = tile % (1 + in_width) - 1;
  const int begin = chunk * per_chunk, end = min(begin + per_chunk, count);
  const int to = chunk * parameters + first + o * (1 + 4 * in_width);
  if (i < 0) {
    vec4 sum = vec4(0);
    for (int s = begin; s < end; ++s) sum += d_pre_activation[s * out_stride + out_at + o];
    sums[to] = sum;
    return;
  }
  mat4 sum = mat4(0);
  for (int s = begin; s < end; ++s)
    sum += outerProduct(d_pre_activation[s * out_stride + out_at + o], trace[s * in_stride + in_at + i]);
  for (int k = 0; k < 4; ++k) sums[to + 1 + 4 * i + k] = sum[k];
}
