#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Volume rendering along rays (../../field/compositing.h, ../../field/ray_rendering.h): what the losses need.
//   seen  [radiance(3), landing(2), inverse depth, share, visible, warped radiance(3)][rays], then
//         [weight, flow residual(6), occlusion towards the neighbour, flow back from there(3)][rays * samples]
// One invocation per ray.
#include "hal/gpu/element.glsl"
#include "online/scene/hash_grid/fit/vulkan/fit_constants.glsl"
layout(std430, set = 0, binding = 0) readonly buffer Rays { vec4 told[]; };
READS(1, Placed, placed)
READS(2, Raw, raw)
// six of a frame, WindowOptions::kMostFrames frames
layout(std140, set = 0, binding = 3) uniform Views { vec4 views[84]; };
layout(std430, set = 0, binding = 4) readonly buffer BasePixels { vec4 base[]; };
WRITES(5, Seen, seen)
#include "online/scene/hash_grid/fit/vulkan/ray.glsl"

void put(int r, int plane, float value) { seen[plane * rays + r] = value; }
void put(int r, int plane, vec3 value) {
  for (int c = 0; c < 3; ++c) put(r, plane + c, value[c]);
}

void main() {
  const int r = column(), n = rays * samples;
  if (r >= rays) return;
  const Ray ray = ray_at(r);
  const View neighbour = from_anchor(ray.there);
  const float static_scale = static_prior(ray.own);
  vec3 radiance = vec3(0), warped = vec3(0);
  vec2 landing = vec2(0);
  float light = 1, light_there = 1, depth = 0, share = 0, visible = 0;
  for (int k = 0; k < samples; ++k) {
    const int s = r * samples + k, moved = n + s, of_samples = 11 * rays + s;
    const bool last = k + 1 == samples;
    const float spacing = placed[5 * ld + s];
    const vec4 density = densities(ray, static_scale, neighbour, s);
    const float total = density.x + density.y + kEmptyDensity, passed = last ? 0 : exp(-total * spacing);
    const float weight = light * (1 - passed);
    const float dynamic_weight = weight * density.y / total, static_weight = weight - dynamic_weight;
    light *= passed;
    radiance += static_weight * radiance_of(exponent_of(ray.own, 0, s));
    if (has_dynamic != 0) radiance += dynamic_weight * radiance_of(exponent_of(ray.own, kDynamic, s));
    depth += weight * placed[4 * ld + s], share += dynamic_weight;
    seen[of_samples] = weight;
    if (has_dynamic != 0)
      [[dont_unroll]] for (int i = 0; i < 6; ++i)
        seen[of_samples + (1 + i) * n] = raw[(kDynamic + 4 + i) * ld + s];
    if (!ray.warps) continue;
    const float occlusion = sigmoid(raw[(kDynamic + 10 + ray.toward) * ld + s]);
    const vec3 at_static = project(neighbour, point_of(s)), at_dynamic = project(neighbour, point_of(moved));
    landing += static_weight * at_static.xy + dynamic_weight * at_dynamic.xy;
    visible += static_weight + dynamic_weight * occlusion;
    const Base static_there = found(spot_at(ray.there, at_static.xy));
    const Base dynamic_there = found(spot_at(ray.there, at_dynamic.xy));
    const float total_there = density.x + density.z + kEmptyDensity;
    const float passed_there = last ? 0 : exp(-total_there * spacing);
    const float weight_there = light_there * (1 - passed_there);
    const float warped_dynamic = weight_there * density.z / total_there;
    light_there *= passed_there;
    warped += (weight_there - warped_dynamic) * radiance_of(exponent_of(static_there, 0, s)) +
              warped_dynamic * radiance_of(exponent_of(dynamic_there, kDynamic, moved));
    seen[of_samples + 7 * n] = occlusion;
    const int back = 1 - ray.toward;
    const vec4 known = vec4(dynamic_there.of[1].zw, dynamic_there.of[2].xy);
    const vec3 flow = triple(kDynamic + 4 + 3 * back, moved) + vec3(back == 0 ? known.xy : known.zw, 0);
    for (int a = 0; a < 3; ++a) seen[of_samples + (8 + a) * n] = flow[a];
  }
  put(r, 0, radiance), put(r, 3, landing.x), put(r, 4, landing.y), put(r, 5, depth), put(r, 6, share);
  put(r, 7, visible), put(r, 8, warped);
}
