#version 450
#extension GL_GOOGLE_include_directive : require
// The radiance that the noise model is asked for: the state where it is known, else the sample.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
  float unseen_from;
};
READS(0, State, state)
READS(1, Samples, samples)
WRITES(2, Guess, guess)
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane(), i = at(c, y, x);
  guess[i] = state[at(kVariance + c, y, x)] < unseen_from ? state[i] : samples[i];
}
