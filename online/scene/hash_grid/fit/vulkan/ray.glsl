// One ray of the fit: the base at its own pixel, the base that its samples find in the neighbour's frame, and
// what the raw outputs mean there; twins are fetch_base() in ../../field/window.h and
// ../../field/field_sample.h. Includers declare what camera.glsl asks for, and
//   told    [rays, 5 vectors]: BasePixel at the ray's pixel; place in the window of the neighbour or -1,
//           Neighbour, slot of the neighbour
//   placed  [u, v, d, slot, inverse depth, spacing][ld]; the samples of a ray side by side, and as many
//           displaced ones behind all of them
//   raw     [static outputs, dynamic outputs][ld], displaced samples as in `placed`
//   base    [frames of the window, rows, cols, 4 vectors]: BasePixel
#include "online/scene/hash_grid/field/branch_constants.h"
#include "online/scene/hash_grid/field/ray_constants.h"
#include "online/scene/hash_grid/field/vulkan/camera.glsl"

const int kDynamic = kStaticOutputs;  // the dynamic outputs' first plane

struct Base {
  vec4 of[4];
};
vec3 log_radiance(Base base) { return base.of[0].xyz; }
vec3 gate(Base base) { return vec3(base.of[0].w, base.of[1].xy); }
float surface(Base base) { return base.of[3].x; }

struct Ray {
  Base own;
  int there, toward;  // the neighbour's place in the window and Neighbour; there is one if warps
  bool warps;
};
Ray ray_at(int r) {
  Ray result;
  for (int k = 0; k < 4; ++k) result.own.of[k] = told[5 * r + k];
  const vec4 aim = told[5 * r + 4];
  result.warps = has_dynamic != 0 && aim.x >= 0;
  result.there = max(int(aim.x), 0), result.toward = int(aim.y);
  return result;
}

// Four pixels of a frame around a place in it, which is clamped to the picture.
struct Spot {
  int a, b, c, d;
  vec2 fraction, inside;  // inside: 0 where it was clamped
};
Spot spot_at(int frame, vec2 pixel) {
  const vec2 free = pixel - 0.5, last = size - 1, at = in_picture(free);
  const int cols = int(size.x), rows = int(size.y);
  const int i = min(int(at.x), max(cols - 2, 0)), j = min(int(at.y), max(rows - 2, 0));
  Spot spot;
  spot.inside = vec2(free.x > 0 && free.x < last.x ? 1 : 0, free.y > 0 && free.y < last.y ? 1 : 0);
  spot.fraction = at - vec2(i, j);
  spot.a = 4 * ((frame * rows + j) * cols + i), spot.b = spot.a + (cols > 1 ? 4 : 0);
  const int below = rows > 1 ? 4 * cols : 0;
  spot.c = spot.a + below, spot.d = spot.b + below;
  return spot;
}
vec4 found(Spot at, int k) {
  return mix(mix(base[at.a + k], base[at.b + k], at.fraction.x),
             mix(base[at.c + k], base[at.d + k], at.fraction.x), at.fraction.y);
}
Base found(Spot at) {
  Base result;
  [[dont_unroll]] for (int k = 0; k < 4; ++k) result.of[k] = found(at, k);
  return result;
}

// The prior of log density, and its slopes by inverse depth and by the surface's inverse depth.
vec3 surface_prior(float inverse_depth, float surface) {
  const float width = kThickness + kThicknessPerDepth * surface, away = (inverse_depth - surface) / width;
  const float peak = kSurface * exp(-0.5 * away * away), slope = peak * away / width;
  return vec3(kEmptySpace + peak, -slope, slope * (1 + away * kThicknessPerDepth));
}

float bounded_exp(float x) { return exp(clamp(x, -kDensityBound, kDensityBound)); }
float sigmoid(float x) { return 1 / (1 + exp(-x)); }
vec3 point_of(int s) { return vec3(placed[s], placed[ld + s], placed[2 * ld + s]); }
vec3 triple(int plane, int s) {
  return vec3(raw[plane * ld + s], raw[(plane + 1) * ld + s], raw[(plane + 2) * ld + s]);
}
vec3 exponent_of(Base known, int plane, int s) {
  return log_radiance(known) + gate(known) * triple(plane + 1, s);
}
vec3 radiance_of(vec3 exponent) { return exp(clamp(exponent, -kRadianceBound, kRadianceBound)); }

// The prior of the static density: a base that moves is not static.
float static_prior(Base own) {
  const vec4 speed = abs(vec4(own.of[1].zw, own.of[2].xy));
  const float fastest = max(max(speed.x, speed.y), max(speed.z, speed.w));
  return exp(-clamp(kPerPixel * (fastest - kStill), 0.0, kLeastStatic));
}
vec3 scene_flow(Ray ray, int s) {
  const int first = 2 * ray.toward;
  const vec4 known = vec4(ray.own.of[1].zw, ray.own.of[2].xy);
  return triple(kDynamic + 4 + 3 * ray.toward, s) + vec3(first == 0 ? known.xy : known.zw, 0);
}

// Densities of sample s, as they add up: static, dynamic, and dynamic where the neighbour sees it; v in w.
vec4 densities(Ray ray, float static_scale, View neighbour, int s) {
  const float prior = surface_prior(placed[4 * ld + s], surface(ray.own)).x;
  const float v = sigmoid(raw[4 * ld + s]);
  vec3 density = vec3(bounded_exp(raw[s] + prior) * static_scale, 0, 0);
  if (has_dynamic != 0) density.y = bounded_exp(raw[kDynamic * ld + s] + prior);
  if (ray.warps) {
    const int moved = rays * samples + s;
    const vec3 landing = project(neighbour, point_of(moved));
    const float there = found(spot_at(ray.there, landing.xy), 3).x;
    density.z = bounded_exp(raw[kDynamic * ld + moved] + surface_prior(landing.z, there).x);
  }
  if (weighted != 0 && has_dynamic != 0) density *= vec3(v, 1 - v, 1 - v);
  return vec4(density, v);
}
