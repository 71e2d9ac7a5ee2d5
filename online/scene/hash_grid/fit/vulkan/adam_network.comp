#version 450
#extension GL_GOOGLE_include_directive : require
// Adam on a network's parameters, in whatever order. One invocation per parameter.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  float rate, gradient_scale, beta1, beta2, epsilon;
  int count;
};
CHANGES(0, Parameters, parameter)
READS(1, Gradient, gradient)
CHANGES(2, Mean, mean)
CHANGES(3, Variance, variance)
#include "online/scene/hash_grid/fit/vulkan/adam.glsl"

void main() {
  const int i = column();
  if (i >= count) return;
  float moved = parameter[i], m = mean[i], v = variance[i];
  adam(gradient[i], moved, m, v);
  parameter[i] = moved, mean[i] = m, variance[i] = v;
}
