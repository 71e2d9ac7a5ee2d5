// One ray through the window: its samples (RaySamples), the rendered values (RayPicture), and their
// gradients. The gradient of either has the same struct. Scalar type T as in hash_grid.h. Reentrant.
#pragma once

#include "online/scene/hash_grid/field/compositing.h"
#include "online/scene/hash_grid/field/field_sample.h"

namespace hdrcam {

template <class T>
struct RaySamples {
  int count = 0;
  bool has_dynamic = true;
  bool warps = false;  // towards a neighbour; needs the dynamic branch
  Neighbour toward = Neighbour::Next;
  T inverse_depth[kMaxSamples], spacing[kMaxSamples];
  T position[kMaxSamples][3];
  FieldSample<T> static_[kMaxSamples], dynamic[kMaxSamples];
  FieldSample<T> static_there[kMaxSamples];  // the static sample with the neighbour's base: radiance only
  FieldSample<T> warped[kMaxSamples];        // the neighbour's dynamic branch at the displaced position
  // the sample in the neighbour's camera (pixel, inverse depth): static, and displaced by the scene flow,
  // with d seen / d window point
  T landing_static[kMaxSamples][3], landing_dynamic[kMaxSamples][3], landing_jacobian[kMaxSamples][3][3];
};

template <class T>
struct RayPicture {
  T radiance[3] = {0, 0, 0};
  T landing[2] = {0, 0};  // the neighbour's pixel that shows the ray's content
  T inverse_depth = 0;
  T share = 0;    // of the dynamic branch
  T visible = 0;  // occlusion weight towards the neighbour
  T warped_radiance[3] = {0, 0, 0};
};

template <class T>
struct RayTrace {
  Composite<T> combined, warped;
};

template <class T>
void set_densities(const RaySamples<T>& ray, Blend blend, Composite<T>& combined, Composite<T>& warped) {
  combined.count = warped.count = ray.count;
  const bool weighted = blend == Blend::Weight && ray.has_dynamic;
  for (int k = 0; k < ray.count; ++k) {
    const T v = ray.static_[k].blend;
    combined.density[0][k] = (weighted ? v : T(1)) * ray.static_[k].density;
    combined.density[1][k] = ray.has_dynamic ? (weighted ? 1 - v : T(1)) * ray.dynamic[k].density : T(0);
    warped.density[0][k] = combined.density[0][k];
    warped.density[1][k] = (weighted ? 1 - v : T(1)) * ray.warped[k].density;
  }
}

template <class T>
RayPicture<T> render_ray(const RaySamples<T>& ray, Blend blend, RayTrace<T>& trace) {
  set_densities(ray, blend, trace.combined, trace.warped);
  composite_ray(ray.spacing, trace.combined);
  RayPicture<T> picture;
  const int n = static_cast<int>(ray.toward);
  for (int k = 0; k < ray.count; ++k) {
    const T dynamic_weight = trace.combined.weight[k] * trace.combined.share[k],
            static_weight = trace.combined.weight[k] - dynamic_weight;
    for (int c = 0; c < 3; ++c)
      picture.radiance[c] +=
          static_weight * ray.static_[k].radiance[c] + dynamic_weight * ray.dynamic[k].radiance[c];
    picture.inverse_depth += (static_weight + dynamic_weight) * ray.inverse_depth[k];
    picture.share += dynamic_weight;
    if (!ray.warps) continue;
    for (int a = 0; a < 2; ++a)
      picture.landing[a] +=
          static_weight * ray.landing_static[k][a] + dynamic_weight * ray.landing_dynamic[k][a];
    picture.visible += static_weight + dynamic_weight * ray.dynamic[k].occlusion[n];
  }
  if (!ray.warps) return picture;
  composite_ray(ray.spacing, trace.warped);
  for (int k = 0; k < ray.count; ++k) {
    const T dynamic_weight = trace.warped.weight[k] * trace.warped.share[k],
            static_weight = trace.warped.weight[k] - dynamic_weight;
    for (int c = 0; c < 3; ++c)
      picture.warped_radiance[c] +=
          static_weight * ray.static_there[k].radiance[c] + dynamic_weight * ray.warped[k].radiance[c];
  }
  return picture;
}

// The gradient of set_densities; `dynamic` names the samples whose density was added to the static one's.
template <class T>
void set_densities_backward(const RaySamples<T>& ray, Blend blend,
                            FieldSample<T> (RaySamples<T>::*dynamic)[kMaxSamples],
                            const T (*d_density)[kMaxSamples], RaySamples<T>& d) {
  const bool weighted = blend == Blend::Weight && ray.has_dynamic;
  for (int k = 0; k < ray.count; ++k) {
    const T v = ray.static_[k].blend;
    d.static_[k].density += (weighted ? v : T(1)) * d_density[0][k];
    if (ray.has_dynamic) (d.*dynamic)[k].density += (weighted ? 1 - v : T(1)) * d_density[1][k];
    if (weighted)
      d.static_[k].blend +=
          d_density[0][k] * ray.static_[k].density - d_density[1][k] * (ray.*dynamic)[k].density;
  }
}

// Adds to `d` (static_, static_there, dynamic, warped) from d_picture and, for losses on the weights
// themselves, d_weight[count]. flow_unit[3]: window units per unit of flow.
template <class T>
void render_ray_backward(const RaySamples<T>& ray, Blend blend, const RayTrace<T>& trace,
                         const RayPicture<T>& d_picture, const T* d_ray_weight, const T* flow_unit,
                         RaySamples<T>& d) {
  const Composite<T>& c = trace.combined;
  const auto n = static_cast<std::size_t>(ray.toward);
  T d_weight[kMaxSamples] = {}, d_share[kMaxSamples] = {}, d_density[2][kMaxSamples];
  for (int k = 0; k < ray.count; ++k) {
    const FieldSample<T>&static_sample = ray.static_[k], &dynamic_sample = ray.dynamic[k];
    const T s = c.share[k], w = c.weight[k];
    T of_static = d_picture.inverse_depth * ray.inverse_depth[k], of_dynamic = of_static + d_picture.share;
    for (int j = 0; j < 3; ++j) {
      of_static += d_picture.radiance[j] * static_sample.radiance[j];
      of_dynamic += d_picture.radiance[j] * dynamic_sample.radiance[j];
      d.static_[k].radiance[j] += w * (1 - s) * d_picture.radiance[j];
      d.dynamic[k].radiance[j] += w * s * d_picture.radiance[j];
    }
    if (ray.warps) {
      of_static += d_picture.visible, of_dynamic += d_picture.visible * dynamic_sample.occlusion[n];
      d.dynamic[k].occlusion[n] += w * s * d_picture.visible;
      for (int a = 0; a < 2; ++a) {
        of_static += d_picture.landing[a] * ray.landing_static[k][a];
        of_dynamic += d_picture.landing[a] * ray.landing_dynamic[k][a];
        for (int j = 0; j < 3; ++j)
          d.dynamic[k].flow[n][j] +=
              w * s * d_picture.landing[a] * ray.landing_jacobian[k][a][j] * flow_unit[j];
      }
    }
    d_weight[k] = d_ray_weight[k] + (1 - s) * of_static + s * of_dynamic;
    d_share[k] = w * (of_dynamic - of_static);
  }
  composite_backward(ray.spacing, c, d_weight, d_share, d_density);
  set_densities_backward(ray, blend, &RaySamples<T>::dynamic, d_density, d);
  if (!ray.warps) return;
  const Composite<T>& there = trace.warped;
  for (int k = 0; k < ray.count; ++k) {
    const T s = there.share[k], w = there.weight[k];
    T of_static = 0, of_dynamic = 0;
    for (int j = 0; j < 3; ++j) {
      of_static += d_picture.warped_radiance[j] * ray.static_there[k].radiance[j];
      of_dynamic += d_picture.warped_radiance[j] * ray.warped[k].radiance[j];
      d.static_there[k].radiance[j] += w * (1 - s) * d_picture.warped_radiance[j];
      d.warped[k].radiance[j] += w * s * d_picture.warped_radiance[j];
    }
    d_weight[k] = (1 - s) * of_static + s * of_dynamic;
    d_share[k] = w * (of_dynamic - of_static);
  }
  composite_backward(ray.spacing, there, d_weight, d_share, d_density);
  set_densities_backward(ray, blend, &RaySamples<T>::warped, d_density, d);
}

}  // namespace hdrcam
