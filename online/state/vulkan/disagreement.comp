#version 450
#extension GL_GOOGLE_include_directive : require
// How far state and samples are apart, in what they may be apart (chi^2), and how much could be compared;
// summed over the channels: found [chi^2, compared].
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
  float unseen_from, exposure, relative2, texture2, blur_tolerance;
};
READS(0, State, state)
READS(1, Samples, samples)
READS(2, Mean, mean)
READS(3, Contrast, contrast)
READS(4, Tables, tables)
WRITES(5, Found, found)
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"
#include "online/state/vulkan/noise.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row();
  float chi2 = 0, covered = 0;
  for (int c = 0; c < 3; ++c) {
    const int i = at(c, y, x);
    const float s = state[i], v = state[at(kVariance + c, y, x)], r = samples[i];
    const float blur = samples[at(kBlur + c, y, x)];
    const float mask = v < unseen_from ? samples[at(kComparable + c, y, x)] : 0;
    const float d = s + blur - r, average = 0.5 * (s + r);
    const float allowed = v + noise_variance(c, mean[i]) + relative2 * average * average +
                          texture2 * contrast[i] + blur_tolerance * blur * blur + kTiny;
    chi2 += mask * d * d / allowed;
    covered += mask;
  }
  found[at(0, y, x)] = chi2;
  found[at(1, y, x)] = covered;
}
