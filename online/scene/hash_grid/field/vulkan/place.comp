#version 450
#extension GL_GOOGLE_include_directive : require
// Samples along rays, near to far (../ray_sampler.h): [u, v, d, inverse depth, spacing][ld], the samples of a
// ray side by side. One invocation per ray.
#include "hal/gpu/element.glsl"
#include "online/scene/hash_grid/field/vulkan/field_constants.glsl"
READS(0, Rays, ray)
layout(std140, set = 0, binding = 1) uniform Views { vec4 views[24]; };
layout(std430, set = 0, binding = 2) readonly buffer BasePixels { vec4 base[]; };
WRITES(3, Placed, placed)
#include "online/scene/hash_grid/field/vulkan/window.glsl"

void main() {
  const int r = column();
  if (r >= rays) return;
  const vec2 pixel = vec2(ray[3 * r], ray[3 * r + 1]);
  const float guide = ray[3 * r + 2];
  const View camera = to_anchor(kCamera);
  float q[17];
  if (samples < kFewSamples) {
    for (int k = 0; k < samples; ++k) q[k] = 1 - (float(k) + 0.5) / float(samples);
    if (samples == 1) q[0] = guide;
  } else {
    const int wide = max(1, samples * kWide / kParts), close = samples - wide;
    const float band = kBand + kBandPerDepth * guide;
    for (int n = 0; n < samples; ++n) {
      const float next =
          n < close ? clamp(guide + band * (1 - 2 * (float(n) + 0.5) / float(close)), 0.0, kNearestSample)
                    : 1 - (float(n - close) + 0.5) / float(wide);
      int k = n;  // sorted into those before it
      for (; k > 0 && q[k - 1] < next; --k) q[k] = q[k - 1];
      q[k] = next;
    }
  }
  for (int k = 0; k < samples; ++k) {
    const int s = r * samples + k;
    const vec3 x = place(camera, pixel, q[k]);
    placed[s] = x.x, placed[ld + s] = x.y, placed[2 * ld + s] = x.z;
    placed[3 * ld + s] = q[k];
    placed[4 * ld + s] = k + 1 < samples ? (q[k] - q[k + 1]) * kOpticalRange : 1;
  }
}
