#version 450
#extension GL_GOOGLE_include_directive : require
// Codes become samples: radiance, weight, fitness to be compared; the blur is set to zero.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
  float fade_begin, fade_end, compare_fade_begin, compare_fade_end, compare_dark_begin, compare_dark_end;
};
READS(0, Codes, codes)
READS(1, Brightest, brightest)
READS(2, Tables, tables)
WRITES(3, Samples, samples)
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  const float code = codes[at(c, y, x)], brighter = max(code, brightest[at(c, y, x)]);
  const float z = clamp(code, 0.0, 255.0);
  const int i = int(z);
  const float low = tables[c * kCodes + i], high = tables[c * kCodes + i + 1];
  samples[at(c, y, x)] = low + (high - low) * (z - float(i));
  samples[at(kWeight + c, y, x)] = 1 - smooth_step(fade_begin, fade_end, brighter);
  samples[at(kComparable + c, y, x)] = (1 - smooth_step(compare_fade_begin, compare_fade_end, brighter)) *
                                       smooth_step(compare_dark_begin, compare_dark_end, code);
  samples[at(kBlur + c, y, x)] = 0;
}
