#include "online/scene/hash_grid/fit/ray_shard.h"

namespace hdrcam {

template <class T>
RayShard<T>::RayShard(const FieldNetworks<T>& networks, int most_rays, int most_samples) {
  HDRCAM_CHECK(most_samples >= 1 && most_samples <= kMaxSamples);
  const int ld = whole_runs(most_rays * most_samples);
  for (auto [pass, branch] : {std::pair(&static_, &networks.static_),
                              {&dynamic_, &networks.dynamic},
                              {&warped_, &networks.dynamic}})
    pass->reserve(*branch, ld), pass->reserve_gradient(*branch, ld);
  d_static_.resize(networks.static_.mlp.parameters().size());
  d_dynamic_.resize(networks.dynamic.mlp.parameters().size());
  ray_.resize(static_cast<std::size_t>(most_rays));
  base_.resize(ray_.size());
  misfit_.resize(ray_.size());
}

template <class T>
void RayShard<T>::zero(BranchPass<T>& pass) {
  pass.d_raw.fill(0);
  pass.d_position.fill(0);
  pass.d_features.fill(0);
}

template <class T>
void RayShard<T>::run(const StepSetting<T>& step, std::span<const TrainingRay> rays, Pcg32 random) {
  HDRCAM_CHECK(rays.size() <= ray_.size());
  sums_ = {};
  std::fill(d_static_.begin(), d_static_.end(), T(0));
  std::fill(d_dynamic_.begin(), d_dynamic_.end(), T(0));
  for (BranchPass<T>* pass : {&static_, &dynamic_, &warped_}) zero(*pass);

  place_rays(step, rays, random);
  static_.forward(step.networks.static_);
  if (step.has_dynamic) {
    dynamic_.forward(step.networks.dynamic);
    follow_flow(step, rays);
    warped_.forward(step.networks.dynamic);
  }
  for (std::size_t r = 0; r < rays.size(); ++r) ray_gradient(step, rays[r], static_cast<int>(r));
  if (step.has_dynamic) {
    warped_.backward(step.networks.dynamic, d_dynamic_);
    warp_backward(step, rays);
    dynamic_.backward(step.networks.dynamic, d_dynamic_);
  }
  static_.backward(step.networks.static_, d_static_);
}

template <class T>
void RayShard<T>::place_rays(const StepSetting<T>& step, std::span<const TrainingRay> rays, Pcg32& random) {
  const int count = step.samples_per_ray, n = whole_runs(static_cast<int>(rays.size()) * count);
  static_.n = n;
  dynamic_.n = warped_.n = step.has_dynamic ? n : 0;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    RaySamples<T>& ray = ray_[r];
    place_ray(step, rays[r], random, ray, base_[r].data());
    const int slot = step.window.frame(rays[r].frame).slot;
    for (int k = 0; k < count; ++k) {
      const int s = static_cast<int>(r) * count + k;
      for (int a = 0; a < 3; ++a)
        static_.position.plane(a)[s] = dynamic_.position.plane(a)[s] = ray.position[k][a];
      dynamic_.slot[static_cast<std::size_t>(s)] = slot;
    }
  }
}

// Displaces the samples along the scene flow of the dynamic branch, in the neighbour's slot; a ray without a
// neighbour keeps its positions.
template <class T>
void RayShard<T>::follow_flow(const StepSetting<T>& step, std::span<const TrainingRay> rays) {
  T unit[3];
  flow_units(step.window.frustum(), unit);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    RaySamples<T>& ray = ray_[r];
    for (int k = 0; k < ray.count; ++k) {
      const int s = static_cast<int>(r) * ray.count + k;
      ray.dynamic[k] = decode_dynamic(dynamic_.raw, s, base_[r].data(), own_prior(static_cast<int>(r), k));
      const T* flow = ray.dynamic[k].flow[static_cast<int>(ray.toward)];
      for (int a = 0; a < 3; ++a)
        warped_.position.plane(a)[s] = ray.position[k][a] + (ray.warps ? flow[a] * unit[a] : T(0));
      warped_.slot[static_cast<std::size_t>(s)] =
          ray.warps ? neighbour(step.window, rays[r]).slot : dynamic_.slot[static_cast<std::size_t>(s)];
    }
  }
}

// Where the samples of a ray land in the neighbour's picture, and what is there, with its base.
template <class T>
void RayShard<T>::land(const StepSetting<T>& step, const TrainingRay& target, int r) {
  RaySamples<T>& ray = ray_[static_cast<std::size_t>(r)];
  const WindowFrame& there = neighbour(step.window, target);
  const ViewGeometry<T> view(step.window.frustum(), there.T_anchor_camera);
  for (int k = 0; k < ray.count; ++k) {
    const int s = r * ray.count + k;
    const T point[3] = {warped_.position.plane(0)[s], warped_.position.plane(1)[s],
                        warped_.position.plane(2)[s]};
    view.project(ray.position[k], ray.landing_static[k], nullptr);
    view.project(point, ray.landing_dynamic[k], ray.landing_jacobian[k]);
    T base_there[kBaseChannels];
    fetch_base(there.base, ray.landing_dynamic[k], base_there);
    const auto prior = surface_prior(ray.landing_dynamic[k][2], base_there[kBaseSurface]);
    ray.warped[k] = decode_dynamic(warped_.raw, s, base_there, prior.log_density);
    fetch_base(there.base, ray.landing_static[k], base_there);
    decode_radiance(static_.raw, s, base_there, ray.static_there[k]);
  }
}

// The losses of a ray, and their gradient back to the raw outputs.
template <class T>
void RayShard<T>::ray_gradient(const StepSetting<T>& step, const TrainingRay& target, int r) {
  RaySamples<T>& ray = ray_[static_cast<std::size_t>(r)];
  const T* base = base_[static_cast<std::size_t>(r)].data();
  for (int k = 0; k < ray.count; ++k)
    ray.static_[k] = decode_static(static_.raw, r * ray.count + k, base, own_prior(r, k));
  if (ray.warps) land(step, target, r);
  RayTrace<T> trace;
  const RayPicture<T> picture = render_ray(ray, step.networks.blend, trace);
  misfit_[static_cast<std::size_t>(r)] = sums_.add(step, target, {ray, trace, picture}, gradient_);

  T unit[3];
  flow_units(step.window.frustum(), unit);
  render_ray_backward(ray, step.networks.blend, trace, gradient_.picture, gradient_.weight, unit,
                      gradient_.samples);
  samples_backward(step, target, r, gradient_.samples);
}

template <class T>
void RayShard<T>::samples_backward(const StepSetting<T>& step, const TrainingRay& target, int r,
                                   const RaySamples<T>& d) {
  const RaySamples<T>& ray = ray_[static_cast<std::size_t>(r)];
  const T* base = base_[static_cast<std::size_t>(r)].data();
  for (int k = 0; k < ray.count; ++k) {
    const int s = r * ray.count + k;
    decode_static_backward(static_.raw, s, base, own_prior(r, k), ray.static_[k], d.static_[k],
                           static_.d_raw);
    if (ray.has_dynamic)
      decode_dynamic_backward(dynamic_.raw, s, base, own_prior(r, k), ray.dynamic[k], d.dynamic[k],
                              dynamic_.d_raw, static_cast<T*>(nullptr));
    if (!ray.warps) continue;
    const Image<BasePixel>& there = neighbour(step.window, target).base;
    T base_there[kBaseChannels], d_x[kBaseChannels], d_y[kBaseChannels], d_base[kBaseChannels] = {};
    fetch_base(there, ray.landing_static[k], base_there);
    decode_radiance_backward(static_.raw, s, base_there, ray.static_there[k], d.static_there[k],
                             static_.d_raw, static_cast<T*>(nullptr));
    fetch_base(there, ray.landing_dynamic[k], base_there, d_x, d_y);
    const auto prior = surface_prior(ray.landing_dynamic[k][2], base_there[kBaseSurface]);
    const T d_prior = decode_dynamic_backward(warped_.raw, s, base_there, prior.log_density, ray.warped[k],
                                              d.warped[k], warped_.d_raw, d_base);
    d_base[kBaseSurface] += d_prior * prior.by_surface;
    T d_landing[3] = {0, 0, d_prior * prior.by_depth};
    for (int i = 0; i < kBaseChannels; ++i)
      d_landing[0] += d_base[i] * d_x[i], d_landing[1] += d_base[i] * d_y[i];
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < 3; ++i)
        warped_.d_position.plane(a)[s] += d_landing[i] * ray.landing_jacobian[k][i][a];
  }
}

// The warped samples' gradient with respect to their positions is the gradient of the scene flow that
// displaced them.
template <class T>
void RayShard<T>::warp_backward(const StepSetting<T>& step, std::span<const TrainingRay> rays) {
  step.networks.dynamic.grid.position_backward(warped_.samples(), warped_.d_features, warped_.d_position);
  T unit[3];
  flow_units(step.window.frustum(), unit);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    if (!ray_[r].warps) continue;
    for (int k = 0; k < ray_[r].count; ++k) {
      const int s = static_cast<int>(r) * ray_[r].count + k;
      for (int a = 0; a < 3; ++a)
        dynamic_.d_raw.plane(DynamicHead::kFlow + 3 * static_cast<int>(ray_[r].toward) + a)[s] +=
            warped_.d_position.plane(a)[s] * unit[a];
    }
  }
}

template <class T>
double RayShard<T>::feature_energy() const {
  double sum = 0;
  for (const BranchPass<T>* pass : {&static_, &dynamic_, &warped_})
    for (int i = 0; i < pass->d_features.channels(); ++i)
      for (int s = 0; s < pass->n; ++s)
        sum += static_cast<double>(pass->d_features.plane(i)[s]) *
               static_cast<double>(pass->d_features.plane(i)[s]);
  return sum;
}

template class RayShard<float>;   // the product
template class RayShard<double>;  // the gradient tests

}  // namespace hdrcam
