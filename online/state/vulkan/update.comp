#version 450
#extension GL_GOOGLE_include_directive : require
// Inverse-variance update of the state by samples. A frame's own samples count whole and set the share; where
// it is the first one (`starts` 1) there is nothing before it, not even a guess;
// later frames' samples (`joins` 1) count as far as the gate says, with the variance of their warp, and their
// share is joined to that of those before; `bounded` 1 where their frame is exposed no shorter.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, joins, bounded, starts, textured;
  float unseen_from, exposure, relative2, blur_variance, unknown_blur_variance, misalignment2, texture_error;
  float ringing;
};
CHANGES(0, State, state)
READS(1, Samples, samples)
READS(2, Mean, mean)
READS(3, Tables, tables)
READS(4, Gate, gate)
READS(5, Contrast, contrast)
READS(6, Motion, motion)
CHANGES(7, Share, share)
READS(8, Detail, detail)  // the local contrast of what the mean is of
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"
#include "online/state/vulkan/guessed.glsl"
#include "online/state/vulkan/noise.glsl"
#include "online/state/vulkan/warp_variance.glsl"

// The twins are in online/state/fusion_kernels.cpp.
float without_ringing(float seen, float variance, float weight) {
  const float sure = variance < unseen_from ? seen - kSureSigmas * sqrt(variance) : seen;
  const float clipped = smoothstep(kSurelyClipped, kFarClipped, sure * exposure);
  return max(weight - ringing * kRingingFades * clipped * (1 - weight), 0.0);
}
bool shows_else(float radiance, float variance, float sample_) {
  return bounded != 0 && variance >= unseen_from && radiance * exposure >= kAtClip && sample_ * exposure < kElse;
}

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), pixel = at(0, y, x);
  const float trust = joins != 0 ? gate[pixel] : 1;
  const float extra = joins != 0 ? warp_variance(motion[pixel], motion[at(1, y, x)], misalignment2) : 0;
  float shared_ = 0;
  for (int c = 0; c < 3; ++c) {
    const int i = at(c, y, x), of_variance = at(kVariance + c, y, x);
    const float s = state[i], r = samples[i], m = mean[i];
    const float blur = samples[at(kBlur + c, y, x)], blur2 = blur * blur;
    float v = state[of_variance], weighs = samples[at(kWeight + c, y, x)];
    if (ringing > 0) weighs = without_ringing(s + blur, v, weighs);
    const bool other = shows_else(s, v, r);
    if (starts == 0 && !other && !(v < unseen_from) && !(weighs < kClipped)) v = min(v, guessed(c, s, r));
    float variance = noise_variance(c, m) + relative2 * m * m, value = r;
    if (v < unseen_from) {
      value = max(0.0, value - blur * blur2 / (blur2 + v + kTiny));
      variance += blur_variance * blur2;
    } else {
      variance += unknown_blur_variance * blur2;
    }
    if (joins != 0) variance += extra * contrast[i];
    if (textured != 0) variance += texture_error * detail[i] + hidden_texture(c, m, detail[i]);
    const float weight = other ? 0 : weighs * trust / (variance + kTiny);
    const float before = 1 / (v + kTiny);
    if (weight > kLeastSignal2 / (m * m + kTiny) || (v < unseen_from && !other)) {
      state[i] = (s * before + value * weight) / (before + weight);
      state[of_variance] = 1 / (before + weight);
      shared_ += weight / (before + weight) * (1.0 / 3);
    } else {
      state[i] = max(r, s);
      state[of_variance] = v;
    }
  }
  share[pixel] = joins != 0 ? share[pixel] * (1 - shared_) + shared_ : shared_;
}
