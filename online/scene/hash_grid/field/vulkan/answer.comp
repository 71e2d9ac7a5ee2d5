#version 450
#extension GL_GOOGLE_include_directive : require
// What rays see: raw outputs become samples (../field_sample.h), samples become a picture
// (../compositing.h, ../ray_rendering.h): [radiance rgb, inverse depth, dynamic share, confidence, flow to the
// next frame, to the previous one][rays]. One invocation per ray.
#include "hal/gpu/element.glsl"
#include "online/scene/hash_grid/field/vulkan/field_constants.glsl"
READS(0, Rays, ray)
READS(1, Placed, placed)
READS(2, Still, still)
READS(3, Moving, moving)
READS(4, Moved, moved)
READS(5, Views, views)
READS(6, Base, base)
WRITES(7, Answers, answers)
#include "online/scene/hash_grid/field/vulkan/window.glsl"

const float kDensityBound = 12, kRadianceBound = 20, kEmpty = 1e-6;

float bounded_exp(float x, float bound) { return exp(clamp(x, -bound, bound)); }

void main() {
  const int r = column();
  if (r >= rays) return;
  const vec2 pixel = vec2(ray[3 * r], ray[3 * r + 1]);
  float light = 1, depth = 0, share = 0, confidence = 0;
  vec3 radiance = vec3(0);
  vec2 flow[2] = {vec2(0), vec2(0)};
  for (int k = 0; k < samples; ++k) {
    const int s = r * samples + k;
    const vec3 point = vec3(placed[s], placed[ld + s], placed[2 * ld + s]);
    float known[kBaseChannels];
    float prior = base_at(point, known);
    // static
    float fastest = 0;
    for (int i = kFlow; i < kFlow + 4; ++i) fastest = max(fastest, abs(known[i]));
    float still_density =
        bounded_exp(still[s] + prior, kDensityBound) * exp(-clamp(4 * (fastest - 0.25), 0.0, 6.0));
    vec3 still_radiance;
    for (int c = 0; c < 3; ++c)
      still_radiance[c] = bounded_exp(known[c] + known[kGate + c] * still[(1 + c) * ld + s], kRadianceBound);
    const float still_known = 1 - (known[kGate] + known[kGate + 1] + known[kGate + 2]) / 3;
    // dynamic
    float moving_density = 0, moving_known = 0;
    vec3 moving_radiance = vec3(0), place_there = point;
    vec3 scene_flow[2] = {vec3(0), vec3(0)};
    if (has_dynamic != 0) {
      if (offset != 0) {
        place_there = vec3(moved[s], moved[ld + s], moved[2 * ld + s]);
        prior = base_at(place_there, known);
      }
      moving_density = bounded_exp(moving[s] + prior, kDensityBound);
      for (int c = 0; c < 3; ++c)
        moving_radiance[c] = bounded_exp(known[c] + known[kGate + c] * moving[(1 + c) * ld + s], kRadianceBound);
      for (int n = 0; n < 2; ++n)
        for (int a = 0; a < 3; ++a)
          scene_flow[n][a] = moving[(4 + 3 * n + a) * ld + s] + (a < 2 ? known[kFlow + 2 * n + a] : 0);
      moving_known = 1 - (known[kGate] + known[kGate + 1] + known[kGate + 2]) / 3;
      if (weighted != 0) {
        const float v = 1 / (1 + exp(-still[4 * ld + s]));
        still_density *= v, moving_density *= 1 - v;
      }
    }
    // compositing
    const float total = still_density + moving_density + kEmpty;
    const float passed = k + 1 < samples ? exp(-total * placed[4 * ld + s]) : 0;
    const float weight = light * (1 - passed);
    const float of_moving = weight * moving_density / total, of_still = weight - of_moving;
    light *= passed;
    radiance += of_still * still_radiance + of_moving * moving_radiance;
    depth += weight * placed[3 * ld + s];
    share += of_moving;
    confidence += of_still * still_known + of_moving * moving_known;
    for (int n = 0; n < 2; ++n) {
      flow[n] += of_still * (project(kNeighbour + n, point).xy - pixel);
      if (has_dynamic != 0)
        flow[n] += of_moving * (project(kNeighbour + n, place_there + scene_flow[n] * unit).xy - pixel);
    }
  }
  for (int c = 0; c < 3; ++c) answers[c * rays + r] = radiance[c];
  answers[3 * rays + r] = depth;
  answers[4 * rays + r] = share;
  answers[5 * rays + r] = confidence;
  for (int n = 0; n < 2; ++n)
    for (int a = 0; a < 2; ++a) answers[(6 + 2 * n + a) * rays + r] = flow[n][a];
}
