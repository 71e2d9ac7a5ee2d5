#version 450
#extension GL_GOOGLE_include_directive : require
// The variance of a carried state: it grows with time, with the warp and where the gate is closed, there up to
// that of a guess.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
  float growth, relative2, misalignment2, gate_floor, unseen_from, lost_variance;
};
CHANGES(0, State, state)
READS(1, Contrast, contrast)
READS(2, Motion, motion)
READS(3, Gate, gate)
READS(4, Samples, samples)
READS(5, Tables, tables)
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"
#include "online/state/vulkan/guessed.glsl"
#include "online/state/vulkan/warp_variance.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  const float s = state[at(c, y, x)], v = state[at(kVariance + c, y, x)], g = gate[at(0, y, x)];
  const float added = warp_variance(motion[at(0, y, x)], motion[at(1, y, x)], misalignment2) * contrast[at(c, y, x)];
  const float aged = v * growth + relative2 * s * s + added;
  const float doubted = aged / max(kLeastGate, g);
  const float lost = g <= gate_floor || !(doubted < lost_variance) ? lost_variance : doubted;
  const float guess = aged < unseen_from ? max(aged, guessed(c, s, samples[at(c, y, x)])) : lost_variance;
  state[at(kVariance + c, y, x)] = samples[at(kWeight + c, y, x)] < kClipped ? lost : min(lost, guess);
}
