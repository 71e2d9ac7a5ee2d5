// One fixed share of the rays of a step: evaluates the field along them, renders, and propagates the
// objective's gradient backward to network outputs and weights. A step runs its shards on any threads; their
// results are summed in their order, so a step gives the same bytes for any number of threads. The gradient
// of the hash tables is scattered later, level by level. Scalar type T as in ../field/hash_grid.h. All
// buffers are allocated by the constructor. Thread-compatible.
#pragma once

#include "online/scene/hash_grid/fit/shard_losses.h"

namespace hdrcam {

template <class T>
class RayShard {
 public:
  RayShard(const FieldNetworks<T>& networks, int most_rays, int most_samples);

  // Computes losses, weight gradients and d_features; `random` jitters the samples along the rays.
  void run(const StepSetting<T>& step, std::span<const TrainingRay> rays, Pcg32 random);
  // Adds the shard's share of the gradient of one level of a branch's tables.
  void scatter_static(int level, HashGrid<T>& grid) const {
    grid.scatter(level, static_.samples(), static_.d_features);
  }
  void scatter_dynamic(int level, HashGrid<T>& grid) const {
    grid.scatter(level, dynamic_.samples(), dynamic_.d_features);
    grid.scatter(level, warped_.samples(), warped_.d_features);
  }

  const LossValues<T>& losses() const { return sums_.losses; }
  std::span<T> d_static() { return d_static_; }
  std::span<T> d_dynamic() { return d_dynamic_; }
  const typename LearnedResponse<T>::Gradient& d_response() const { return sums_.d_response; }
  // photometric misfit per ray, for the choice of pixels
  std::span<const float> misfits() const { return misfit_; }
  // sum of squares of d_features: finite only if every gradient that reaches the tables is
  double feature_energy() const;

 private:
  void place_rays(const StepSetting<T>& step, std::span<const TrainingRay> rays, Pcg32& random);
  void follow_flow(const StepSetting<T>& step, std::span<const TrainingRay> rays);
  void land(const StepSetting<T>& step, const TrainingRay& target, int r);
  void ray_gradient(const StepSetting<T>& step, const TrainingRay& target, int r);
  void samples_backward(const StepSetting<T>& step, const TrainingRay& target, int r, const RaySamples<T>& d);
  void warp_backward(const StepSetting<T>& step, std::span<const TrainingRay> rays);
  static void zero(BranchPass<T>& pass);
  T own_prior(int r, int k) const {
    const auto at = static_cast<std::size_t>(r);
    return surface_prior(ray_[at].inverse_depth[k], base_[at][kBaseSurface]).log_density;
  }
  static const WindowFrame& neighbour(const Window& window, const TrainingRay& ray) {
    return window.frame(neighbour_of(ray));
  }

  BranchPass<T> static_, dynamic_, warped_;
  std::vector<T> d_static_, d_dynamic_;
  std::vector<RaySamples<T>> ray_;
  std::vector<std::array<T, kBaseChannels>> base_;  // of each ray, at its own pixel
  std::vector<float> misfit_;
  ShardLosses<T> sums_;
  RayGradient<T> gradient_;  // of one ray after the other
};

}  // namespace hdrcam
