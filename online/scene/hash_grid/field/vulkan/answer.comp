#version 450
#extension GL_GOOGLE_include_directive : require
// What rays see: raw outputs become samples (../field_sample.h), samples become a picture
// (../compositing.h, ../ray_rendering.h): [radiance rgb, inverse depth, confidence, flow to the
// next frame, to the previous one][rays]. One invocation per ray.
#include "hal/gpu/element.glsl"
#include "online/scene/hash_grid/field/vulkan/field_constants.glsl"
READS(0, Rays, ray)
READS(1, Placed, placed)
READS(2, Static, static_raw)
READS(3, Dynamic, dynamic_raw)
READS(4, Moved, moved)
layout(std140, set = 0, binding = 5) uniform Views { vec4 views[24]; };
layout(std430, set = 0, binding = 6) readonly buffer BasePixels { vec4 base[]; };
WRITES(7, Answers, answers)
#include "online/scene/hash_grid/field/vulkan/window.glsl"

float bounded_exp(float x, float bound) { return exp(clamp(x, -bound, bound)); }

vec3 radiance_of(Base known, vec3 residual) {
  return exp(clamp(known.log_radiance + known.gate * residual, -kRadianceBound, kRadianceBound));
}
float known_share(Base known) { return 1 - dot(known.gate, vec3(1)) / 3; }

void main() {
  const int r = column();
  if (r >= rays) return;
  const vec2 pixel = vec2(ray[3 * r], ray[3 * r + 1]);
  const View frame = from_anchor(kFrame);
  const View neighbour[2] = {from_anchor(kNeighbour), from_anchor(kNeighbour + 1)};
  float light = 1, depth = 0, confidence = 0;
  vec3 radiance = vec3(0);
  vec2 flow[2] = {vec2(0), vec2(0)};
  for (int k = 0; k < samples; ++k) {
    const int s = r * samples + k;
    const vec3 point = vec3(placed[s], placed[ld + s], placed[2 * ld + s]);
    Base known = base_at(frame, point);
    // static
    const vec4 speed = abs(known.flow);
    const float fastest = max(max(speed.x, speed.y), max(speed.z, speed.w));
    float static_density = bounded_exp(static_raw[s] + known.log_density, kDensityBound) *
                          exp(-clamp(kPerPixel * (fastest - kStill), 0.0, kLeastStatic));
    const vec3 static_radiance =
        radiance_of(known, vec3(static_raw[ld + s], static_raw[2 * ld + s], static_raw[3 * ld + s]));
    const float static_known = known_share(known);
    // dynamic
    float dynamic_density = 0, dynamic_known = 0;
    vec3 dynamic_radiance = vec3(0), place_there = point;
    vec3 scene_flow[2] = {vec3(0), vec3(0)};
    if (has_dynamic != 0) {
      if (offset != 0) {
        place_there = vec3(moved[s], moved[ld + s], moved[2 * ld + s]);
        known = base_at(frame, place_there);
      }
      dynamic_density = bounded_exp(dynamic_raw[s] + known.log_density, kDensityBound);
      dynamic_radiance =
          radiance_of(known, vec3(dynamic_raw[ld + s], dynamic_raw[2 * ld + s], dynamic_raw[3 * ld + s]));
      for (int n = 0; n < 2; ++n)
        for (int a = 0; a < 3; ++a)
          scene_flow[n][a] = dynamic_raw[(4 + 3 * n + a) * ld + s] + (a < 2 ? known.flow[2 * n + a] : 0);
      dynamic_known = known_share(known);
      if (weighted != 0) {
        const float v = 1 / (1 + exp(-static_raw[4 * ld + s]));
        static_density *= v, dynamic_density *= 1 - v;
      }
    }
    // compositing
    const float total = static_density + dynamic_density + kEmptyDensity;
    const float passed = k + 1 < samples ? exp(-total * placed[4 * ld + s]) : 0;
    const float weight = light * (1 - passed);
    const float of_dynamic = weight * dynamic_density / total, of_static = weight - of_dynamic;
    light *= passed;
    radiance += of_static * static_radiance + of_dynamic * dynamic_radiance;
    depth += weight * placed[3 * ld + s];
    confidence += of_static * static_known + of_dynamic * dynamic_known;
    for (int n = 0; n < 2; ++n) {
      flow[n] += of_static * (project(neighbour[n], point).xy - pixel);
      if (has_dynamic != 0)
        flow[n] += of_dynamic * (project(neighbour[n], place_there + scene_flow[n] * unit).xy - pixel);
    }
  }
  for (int c = 0; c < 3; ++c) answers[c * rays + r] = radiance[c];
  answers[3 * rays + r] = depth;
  answers[4 * rays + r] = confidence;
  for (int n = 0; n < 2; ++n)
    for (int a = 0; a < 2; ++a) answers[(5 + 2 * n + a) * rays + r] = flow[n][a];
}
