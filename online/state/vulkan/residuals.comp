#version 450
#extension GL_GOOGLE_include_directive : require
// How far samples are from what the state predicted of them, where that can be judged
// (online/state/sample_residuals.cpp): for every second pixel of some lines, and each channel, the residual, the variance that was
// expected of it and its bin; bin -1 where it is left out. found [residual rgb, variance rgb, bin rgb].
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, found_rows, found_cols, line_step, bins;
  float unseen_from, exposure, least_confidence, misalignment, relative2;
};
READS(0, State, state)
READS(1, Samples, samples)
READS(2, Motion, motion)
READS(3, Tables, tables)
READS(4, Excess, excess)
WRITES(5, Found, found)
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"
#include "online/state/vulkan/noise.glsl"

void main() {
  if (column() >= found_cols) return;
  const int c = plane(), x = 1 + 2 * column(), y = 1 + line_step * row();
  const int size = found_rows * found_cols, to = c * size + row() * found_cols + column();
  found[to] = 0, found[3 * size + to] = 0, found[6 * size + to] = -1;
  const float s = state[at(c, y, x)], v = state[at(kVariance + c, y, x)];
  if (motion[at(kConfidence, y, x)] < least_confidence || v >= unseen_from || samples[at(kWeight + c, y, x)] < kUnclipped) return;
  const float variance = noise_variance(c, s) + v;
  const float slope_x = state[at(c, y, x + 1)] - state[at(c, y, x - 1)];
  const float slope_y = state[at(c, y + 1, x)] - state[at(c, y - 1, x)];
  const float misplaced = misalignment * (slope_x * slope_x + slope_y * slope_y);
  if (misplaced > variance + relative2 * s * s) return;
  const float place = clamp(-kBinsPerStop * log2(max(s * exposure, kLeastExposure)) - 0.5, 0.0, float(bins - 1));
  const int i = min(int(place), bins - 2);
  const float low = excess[c * bins + i], high = excess[c * bins + i + 1];
  found[to] = (samples[at(c, y, x)] - s - samples[at(kBlur + c, y, x)]) * exposure;
  found[3 * size + to] = variance * exposure * exposure - (low + (high - low) * (place - float(i)));
  found[6 * size + to] = floor(place + 0.5);
}
