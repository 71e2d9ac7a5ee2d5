#version 450
#extension GL_GOOGLE_include_directive : require
// The scene as the blur's model takes it: the state where it and the motion are believed, else the sample.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
  float known, believed;
};
READS(0, State, state)
READS(1, Samples, samples)
READS(2, Motion, motion)
WRITES(3, Shown, shown)
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  const bool trusted = motion[at(kConfidence, y, x)] > believed && state[at(kVariance + c, y, x)] < known;
  shown[at(c, y, x)] = trusted ? state[at(c, y, x)] : samples[at(c, y, x)];
}
