#version 450
#extension GL_GOOGLE_include_directive : require
// What motion during an exposure adds to the state (online/state/exposure_blur.cpp), into the samples.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols;
  float fraction;
};
READS(0, State, state)
READS(1, Motion, motion)
WRITES(2, Samples, samples)
#include "online/pictures/vulkan/picture.glsl"
#include "online/state/vulkan/state.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  const float dx = motion[at(0, y, x)], dy = motion[at(1, y, x)];
  const float reach = sqrt(dx * dx + dy * dy) * fraction;
  if (rows < 2 || cols < 2 || !(reach >= kLeastBlur)) {
    samples[at(kBlur + c, y, x)] = 0;
    return;
  }
  const int count = clamp(int(ceil(kTapsPerPixel * min(reach, kLongest))) + 1, kLeastTaps, kMostTaps);
  const vec2 last = vec2(cols - 1, rows - 1), here = vec2(x, y);
  float sum = 0;
  for (int k = 0; k < count; ++k) {
    const float instant = fraction * ((float(k) + 0.5) / float(count) - 0.5);
    // what is seen then moves as the place does where it is seen
    const ivec2 then = ivec2(clamp(here + instant * vec2(dx, dy), vec2(0), last) + 0.5);
    const vec2 moves = vec2(motion[at(0, then.y, then.x)], motion[at(1, then.y, then.x)]);
    const vec2 seen = clamp(here + instant * moves, vec2(0), last);
    const ivec2 corner = min(ivec2(seen), ivec2(cols - 2, rows - 2));
    const vec2 f = seen - vec2(corner);
    const int i = at(c, corner.y, corner.x);
    const float upper = state[i] + (state[i + 1] - state[i]) * f.x;
    const float lower = state[i + cols] + (state[i + cols + 1] - state[i + cols]) * f.x;
    sum += upper + (lower - upper) * f.y;
  }
  samples[at(kBlur + c, y, x)] = sum / float(count) - state[at(c, y, x)];
}
