#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// The gradient of render.comp: from that of what it gives (`d_seen`, laid out as its `seen`) to the networks'
// raw outputs and the places of the displaced samples. Twins: render_ray_backward() in
// ../../field/ray_rendering.h, samples_backward() in ../ray_shard.cpp. What has no gradient is left as it is,
// zero.
//   d_raw  [static outputs, dynamic outputs, displaced place(3)][ld]; a displaced sample's place stands where
//          the sample that it was is
// One invocation per ray.
#include "hal/gpu/element.glsl"
#include "online/scene/hash_grid/fit/vulkan/fit_constants.glsl"
layout(std430, set = 0, binding = 0) readonly buffer Rays { vec4 told[]; };
READS(1, Placed, placed)
READS(2, Raw, raw)
// six of a frame, WindowOptions::kMostFrames frames
layout(std140, set = 0, binding = 3) uniform Views { vec4 views[84]; };
layout(std430, set = 0, binding = 4) readonly buffer BasePixels { vec4 base[]; };
READS(5, SeenGradient, d_seen)
WRITES(6, RawGradient, d_raw)
#include "online/scene/hash_grid/fit/vulkan/ray.glsl"

const int kPlace = kStaticOutputs + kDynamicOutputs;
// Of the ray's samples: densities(), and the light that reaches them, here and as the neighbour sees it.
vec4 density_of[kMaxSamples];
float transmittance[kMaxSamples], transmittance_there[kMaxSamples];

float d_ray(int plane, int r) { return d_seen[plane * rays + r]; }
vec3 d_ray3(int plane, int r) { return vec3(d_ray(plane, r), d_ray(plane + 1, r), d_ray(plane + 2, r)); }
float d_sample(int plane, int s) { return d_seen[11 * rays + plane * rays * samples + s]; }
vec3 d_sample3(int plane, int s) {
  return vec3(d_sample(plane, s), d_sample(plane + 1, s), d_sample(plane + 2, s));
}
void put3(int plane, int s, vec3 value) {
  for (int c = 0; c < 3; ++c) d_raw[(plane + c) * ld + s] = value[c];
}

// d density: static, dynamic, of one sample of a composite (composite_backward() of
// ../../field/compositing.h). behind: sum of w d_w of the samples behind it, which this one joins.
vec2 composite_backward(float static_density, float dynamic_density, float spacing, float transmitted,
                        bool last, float d_weight, float d_dynamic_share, inout float behind) {
  const float total = static_density + dynamic_density + kEmptyDensity;
  const float passed = last ? 0 : exp(-total * spacing);
  const float share = dynamic_density / total, weight = transmitted * (1 - passed);
  const float d_total = last ? 0 : spacing * (transmitted * passed * d_weight - behind);
  behind += weight * d_weight;
  return vec2(d_total - d_dynamic_share * share / total, d_total + d_dynamic_share * (1 - share) / total);
}

// d exponent of a bounded radiance.
vec3 radiance_backward(vec3 exponent, vec3 d_radiance) {
  return mix(vec3(0), d_radiance * radiance_of(exponent), lessThan(abs(exponent), vec3(kRadianceBound)));
}
// d exponent of a bounded density, whatever it was multiplied with.
float density_backward(float exponent, float density, float d_density) {
  return abs(exponent) < kDensityBound ? d_density * density : 0;
}

// d seen / d window point, transposed: rows u, v, d (ViewGeometry::project).
void projection_jacobian(View from, vec3 x, out vec3 d_u, out vec3 d_v, out vec3 d_d) {
  const vec2 direction = (((x.xy - 0.5) * margin + 0.5) * size - centre) / focal;
  const float q = (x.z - kDepthOffset) / kDepthScale;
  const vec4 p4 = vec4(direction, 1, q);
  const float free = dot(from.z, p4), z = max(free, kNearest);
  const vec2 p = vec2(dot(from.x, p4), dot(from.y, p4)) / z;
  const bool behind = free < kNearest;
  const vec3 per_x = vec3(margin * size / focal, 1 / kDepthScale);
  const vec3 d_x = vec3(from.x.xy, from.x.w), d_y = vec3(from.y.xy, from.y.w);
  const vec3 d_z = behind ? vec3(0) : vec3(from.z.xy, from.z.w);
  const vec3 to_x = focal.x / z * (d_x - p.x * d_z) * per_x, to_y = focal.y / z * (d_y - p.y * d_z) * per_x;
  const vec3 to_depth = (vec3(0, 0, 1) - q / z * d_z) / z * per_x;
  d_u = vec3(to_x.x, to_y.x, to_depth.x);
  d_v = vec3(to_x.y, to_y.y, to_depth.y);
  d_d = vec3(to_x.z, to_y.z, to_depth.z);
}

// The displaced sample, `moved`: its raw outputs, and the place that they were read at.
void displaced_backward(Ray ray, View neighbour, int s, int moved, vec3 point, vec3 landing, Spot at,
                        Base there, vec3 exponent, vec3 d_radiance, float density, float d_density) {
  const vec3 d_exponent = radiance_backward(exponent, d_radiance);
  const vec3 d_gate = d_exponent * triple(kDynamic + 1, moved), prior = surface_prior(landing.z, surface(there));
  const float d_prior = density_backward(raw[kDynamic * ld + moved] + prior.x, density, d_density);
  const vec3 d_back = d_sample3(8, s);
  const int back = 1 - ray.toward;
  d_raw[kDynamic * ld + moved] = d_prior;
  put3(kDynamic + 1, moved, d_exponent * gate(there));
  put3(kDynamic + 4 + 3 * back, moved, d_back);
  Base d_base;  // of the same place
  d_base.of[0] = vec4(d_exponent, d_gate.x);
  d_base.of[1] = vec4(d_gate.yz, back == 0 ? d_back.xy : vec2(0));
  d_base.of[2] = vec4(back == 1 ? d_back.xy : vec2(0), 0, 0);
  d_base.of[3] = vec4(d_prior * prior.z, 0, 0, 0);
  vec3 d_landing = vec3(0, 0, d_prior * prior.y);
  [[dont_unroll]] for (int k = 0; k < 4; ++k) {
    const vec4 a = base[at.a + k], b = base[at.b + k], c = base[at.c + k], d = base[at.d + k];
    d_landing.x += at.inside.x * dot(d_base.of[k], mix(b - a, d - c, at.fraction.y));
    d_landing.y += at.inside.y * dot(d_base.of[k], mix(c - a, d - b, at.fraction.x));
  }
  vec3 d_u, d_v, d_d;
  projection_jacobian(neighbour, point, d_u, d_v, d_d);
  put3(kPlace, s, vec3(dot(d_landing, d_u), dot(d_landing, d_v), dot(d_landing, d_d)));
}

// What the neighbour's picture of sample k says of it: adds to d_density (static, dynamic, displaced, as they
// add up) and to the gradient of the static residual.
void neighbour_backward(Ray ray, View neighbour, int s, int moved, int k, bool last, vec3 d_warped,
                        vec3 landing_static, inout float behind, inout vec3 d_density,
                        inout vec3 d_residual) {
  const vec4 density = density_of[k];
  const float spacing = placed[5 * ld + s], total = density.x + density.z + kEmptyDensity, share = density.z / total;
  const float weight = transmittance_there[k] * (last ? 1 : 1 - exp(-total * spacing));
  const vec3 point = point_of(moved), landing = project(neighbour, point);
  const Base static_there = found(spot_at(ray.there, landing_static.xy));
  const Spot at = spot_at(ray.there, landing.xy);
  const Base dynamic_there = found(at);
  const vec3 static_exponent = exponent_of(static_there, 0, s);
  const vec3 dynamic_exponent = exponent_of(dynamic_there, kDynamic, moved);
  const float of_static = dot(d_warped, radiance_of(static_exponent));
  const float of_dynamic = dot(d_warped, radiance_of(dynamic_exponent));
  const vec2 d = composite_backward(density.x, density.z, spacing, transmittance_there[k], last,
                                    (1 - share) * of_static + share * of_dynamic,
                                    weight * (of_dynamic - of_static), behind);
  d_density += vec3(d.x, 0, d.y);
  d_residual += radiance_backward(static_exponent, weight * (1 - share) * d_warped) * gate(static_there);
  displaced_backward(ray, neighbour, s, moved, point, landing, at, dynamic_there, dynamic_exponent,
                     weight * share * d_warped, density.z, d.y);
}

// The gradient of where a sample lands in the neighbour's picture, and of how far it is visible there: by the
// weights of static and dynamic, and by the scene flow.
struct Landing {
  vec3 at_static;
  float of_static, of_dynamic;
  vec3 per_share_flow;  // d flow per weight of the dynamic part
};
Landing landing_backward(View neighbour, int s, int moved, float occlusion, vec2 d_landing, float d_visible) {
  vec3 d_u, d_v, d_d;
  const vec3 point = point_of(moved);
  projection_jacobian(neighbour, point, d_u, d_v, d_d);
  Landing at;
  at.at_static = project(neighbour, point_of(s));
  at.of_static = d_visible + dot(d_landing, at.at_static.xy);
  at.of_dynamic = d_visible * occlusion + dot(d_landing, project(neighbour, point).xy);
  at.per_share_flow = unit * vec3(dot(d_landing, d_u.xy), dot(d_landing, d_v.xy), dot(d_landing, d_d.xy));
  return at;
}

void light_up(Ray ray, View neighbour, int r) {
  const float static_scale = static_prior(ray.own);
  float light = 1, light_there = 1;
  for (int k = 0; k < samples; ++k) {
    const int s = r * samples + k;
    const float spacing = placed[5 * ld + s];
    const vec4 density = densities(ray, static_scale, neighbour, s);
    density_of[k] = density;
    transmittance[k] = light, transmittance_there[k] = light_there;
    light *= exp(-(density.x + density.y + kEmptyDensity) * spacing);
    light_there *= exp(-(density.x + density.z + kEmptyDensity) * spacing);
  }
}

// From the gradient of the densities as they add up, and of the static residual, to the raw outputs. A density
// that adds up is its own times v or 1 - v; so is its gradient by the exponent.
void put_static(int s, float prior, vec4 density, vec3 d_density, vec3 d_residual) {
  const bool blends = weighted != 0 && has_dynamic != 0;
  const float v = density.w;
  d_raw[s] = density_backward(raw[s] + prior, density.x, d_density.x);
  put3(1, s, d_residual);
  d_raw[4 * ld + s] = blends ? d_density.x * density.x * (1 - v) - dot(d_density.yz, density.yz) * v : 0;
}

void main() {
  const int r = column(), n = rays * samples;
  if (r >= rays) return;
  const Ray ray = ray_at(r);
  const View neighbour = from_anchor(ray.there);
  light_up(ray, neighbour, r);
  const vec3 d_radiance = d_ray3(0, r), d_warped = d_ray3(8, r);
  float behind = 0, behind_there = 0;
  for (int k = samples - 1; k >= 0; --k) {
    const int s = r * samples + k, moved = n + s;
    const bool last = k + 1 == samples;
    const vec4 density = density_of[k];
    const float q = placed[4 * ld + s], spacing = placed[5 * ld + s];
    const float total = density.x + density.y + kEmptyDensity, share = density.y / total;
    const float weight = transmittance[k] * (last ? 1 : 1 - exp(-total * spacing));
    const vec3 static_exponent = exponent_of(ray.own, 0, s);
    float of_static = d_ray(5, r) * q + dot(d_radiance, radiance_of(static_exponent));
    float of_dynamic = d_ray(5, r) * q + d_ray(6, r);
    vec3 dynamic_exponent = vec3(0);
    if (has_dynamic != 0) {
      dynamic_exponent = exponent_of(ray.own, kDynamic, s);
      of_dynamic += dot(d_radiance, radiance_of(dynamic_exponent));
    }
    const int plane_of_occlusion = kDynamic + 10 + ray.toward;
    float occlusion = 0;
    Landing landing = Landing(vec3(0), 0, 0, vec3(0));
    if (ray.warps) {
      occlusion = sigmoid(raw[plane_of_occlusion * ld + s]);
      landing = landing_backward(neighbour, s, moved, occlusion, vec2(d_ray(3, r), d_ray(4, r)), d_ray(7, r));
      of_static += landing.of_static, of_dynamic += landing.of_dynamic;
    }
    vec3 d_density = vec3(0);
    vec3 d_residual = radiance_backward(static_exponent, weight * (1 - share) * d_radiance) * gate(ray.own);
    d_density.xy = composite_backward(density.x, density.y, spacing, transmittance[k], last,
                                      d_sample(0, s) + (1 - share) * of_static + share * of_dynamic,
                                      weight * (of_dynamic - of_static), behind);
    if (ray.warps)
      neighbour_backward(ray, neighbour, s, moved, k, last, d_warped, landing.at_static, behind_there,
                         d_density, d_residual);
    const float prior = surface_prior(q, surface(ray.own)).x;
    put_static(s, prior, density, d_density, d_residual);
    if (has_dynamic == 0) continue;
    d_raw[kDynamic * ld + s] = density_backward(raw[kDynamic * ld + s] + prior, density.y, d_density.y);
    put3(kDynamic + 1, s, radiance_backward(dynamic_exponent, weight * share * d_radiance) * gate(ray.own));
    const vec3 d_flow = weight * share * landing.per_share_flow;
    [[dont_unroll]] for (int i = 0; i < 2; ++i)
      put3(kDynamic + 4 + 3 * i, s, d_sample3(1 + 3 * i, s) + (i == ray.toward ? d_flow : vec3(0)));
    if (!ray.warps) continue;
    const float d_occlusion = weight * share * d_ray(7, r) + d_sample(7, s);
    d_raw[plane_of_occlusion * ld + s] = d_occlusion * occlusion * (1 - occlusion);
  }
}
