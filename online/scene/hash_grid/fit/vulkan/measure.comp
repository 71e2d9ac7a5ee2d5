#version 450
#extension GL_GOOGLE_include_directive : require
// How large the gradient of the features is: the sum of its squares over a chunk of samples, in their order,
// and the largest magnitude of each level (a maximum does not depend on order; magnitudes compare like their
// bits). One invocation per chunk and feature.
//   energy  [features][chunks]      peak  [levels]
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants { int count, per_chunk, chunks, ld; };
READS(0, FeatureGradient, d_features)
WRITES(1, Energy, energy)
layout(std430, set = 0, binding = 2) buffer Peak { uint peak[]; };

void main() {
  const int chunk = column(), feature = row();
  if (chunk >= chunks) return;
  const int begin = chunk * per_chunk, end = min(begin + per_chunk, count);
  float sum = 0, largest = 0;
  for (int s = begin; s < end; ++s) {
    const float d = d_features[feature * ld + s];
    sum += d * d;
    largest = max(largest, abs(d));
  }
  energy[feature * chunks + chunk] = sum;
  if (largest > 0) atomicMax(peak[feature / 2], floatBitsToUint(largest));
}
