#version 450
#extension GL_GOOGLE_include_directive : require
// How far to trust that state and samples show the same thing: agreement around the pixel, confidence of the
// motion, and the bound that a clipped sample gives.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
  float tolerance, scale, least;
};
READS(0, State, state)
READS(1, Samples, samples)
READS(2, Found, found)
READS(3, Motion, motion)
WRITES(4, Gate, gate)
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row();
  const float chi2 = found[at(0, y, x)], covered = found[at(1, y, x)];
  const float excess = max(0.0, chi2 / (covered + kHardlyCompared) - tolerance);
  const float agreement = 1 - min(1.0, covered) * (1 - least) * (1 - exp(-excess / scale));
  float bound = 1;
  for (int c = 0; c < 3; ++c) {
    if (samples[at(kWeight + c, y, x)] >= kClipped) continue;
    const float ratio = state[at(c, y, x)] / (kBound * samples[at(c, y, x)] + kTiny);
    const float below = (1 - ratio) / kBelowBound;
    if (ratio < 1) bound = min(bound, exp(-below * below));
  }
  gate[at(0, y, x)] = motion[at(kConfidence, y, x)] * agreement * (least + (1 - least) * bound);
}
