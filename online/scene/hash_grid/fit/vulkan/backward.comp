#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// The backward pass of a small network (../../field/mlp.h): from the gradient of its raw outputs to that of
// its features, and what the gradient of its weights is made of (outer.comp). One invocation per sample, which
// computes its activations anew: that costs a third more arithmetic, and no memory between the passes.
//   trace             [samples][features, hidden, hidden]: the layers' inputs
//   d_pre_activation  [samples][hidden, hidden, outputs]: the gradients of the layers' sums
#include "hal/gpu/element.glsl"
#include "online/scene/hash_grid/field/branch_constants.h"
layout(push_constant) uniform Constants {
  int first, count, ld, inputs, hidden, outputs, plane_of_raw;  // samples first .. first + count - 1
};
READS(0, Features, features)
READS(1, RawGradient, d_raw)
layout(std140, set = 0, binding = 2) uniform Parameters { vec4 parameter[kMostParameters / 4]; };
CHANGES(3, Trace, trace)
CHANGES(4, PreActivationGradient, d_pre_activation)
WRITES(5, FeatureGradient, d_features)

float from[kMostWidth], to[kMostWidth];

// to <- rectified sums of `from`; kept in the trace at `place`, and left in `from`.
void layer(int first_parameter, int in_width, int place) {
  for (int o = 0; o < hidden; o += 4) {
    const int tile = first_parameter + o / 4 * (1 + in_width);
    vec4 sum = parameter[tile];
    for (int i = 0; i < in_width; ++i) sum += parameter[tile + 1 + i] * from[i];
    sum = max(sum, 0);
    for (int k = 0; k < 4; ++k) to[o + k] = sum[k];
  }
  for (int i = 0; i < hidden; ++i) from[i] = trace[place + i] = to[i];
}

// to <- the gradient of a layer's inputs from that of its sums, `from`.
void layer_backward(int first_parameter, int in_width, int out_width) {
  for (int i = 0; i < in_width; ++i) {
    float sum = 0;
    for (int o = 0; o < out_width; o += 4)
      sum += dot(parameter[first_parameter + o / 4 * (1 + in_width) + 1 + i],
                 vec4(from[o], from[o + 1], from[o + 2], from[o + 3]));
    to[i] = sum;
  }
}

// The same through a rectifier whose outputs are in the trace at `active_at`; kept in d_pre_activation at
// `place`.
void rectify(int active_at, int place) {
  for (int i = 0; i < hidden; ++i)
    from[i] = d_pre_activation[place + i] = trace[active_at + i] > 0 ? to[i] : 0;
}

// Drivers compile each copy of a layer: there is one forward and one backward.
void main() {
  const int s = first + column();
  if (column() >= count) return;
  const int second = hidden / 4 * (1 + inputs), third = second + hidden / 4 * (1 + hidden);
  const int at = s * (inputs + 2 * hidden), gradient_at = s * (2 * hidden + outputs);
  for (int i = 0; i < inputs; ++i) from[i] = trace[at + i] = features[i * ld + s];
  [[dont_unroll]] for (int l = 0; l < 2; ++l)
    layer(l == 0 ? 0 : second, l == 0 ? inputs : hidden, at + inputs + l * hidden);
  for (int o = 0; o < outputs; ++o)
    from[o] = d_pre_activation[gradient_at + 2 * hidden + o] = d_raw[(plane_of_raw + o) * ld + s];
  [[dont_unroll]] for (int l = 2; l >= 0; --l) {
    layer_backward(l == 0 ? 0 : l == 1 ? second : third, l == 0 ? inputs : hidden, l == 2 ? outputs : hidden);
    if (l > 0) rectify(at + inputs + (l - 1) * hidden, gradient_at + (l - 1) * hidden);
  }
  for (int i = 0; i < inputs; ++i) d_features[i * ld + s] = to[i];
}
