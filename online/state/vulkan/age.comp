#version 450
#extension GL_GOOGLE_include_directive : require
// The variance of a carried state: it grows with time, with the warp and where the gate is closed.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
  float growth, relative2, misalignment2, least, unseen;
};
CHANGES(0, State, state)
READS(1, Contrast, contrast)
READS(2, Motion, motion)
READS(3, Gate, gate)
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"
#include "online/state/vulkan/warp_variance.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  const float s = state[at(c, y, x)], v = state[at(kVariance + c, y, x)], g = gate[at(0, y, x)];
  const float added = warp_variance(motion[at(0, y, x)], motion[at(1, y, x)], misalignment2) * contrast[at(c, y, x)];
  const float carried = (v * growth + relative2 * s * s + added) / max(1e-4, g);
  state[at(kVariance + c, y, x)] = g < least || !(carried < unseen) ? unseen : carried;
}
