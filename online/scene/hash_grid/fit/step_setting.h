// The constants of a step, and the samples of its rays: where they are along a ray, and what the base says at
// the ray's pixel. Scalar type T as in ../field/hash_grid.h. Reentrant.
#pragma once

#include "online/scene/hash_grid/field/ray_sampler.h"
#include "online/scene/hash_grid/fit/objective.h"

namespace hdrcam {

// Rays of a step that share random numbers, and whose losses and gradients are added up together.
constexpr int kRaysPerShard = 32;

template <class T>
struct StepSetting {
  const FieldNetworks<T>& networks;
  const Window& window;
  const LearnedResponse<T>& response;
  const LossWeights& weights;
  int samples_per_ray;
  bool has_dynamic, fits_response;
  T ray_share;  // one over the rays of the step
};

// The random numbers of a step: of each shard a stream of its own, first_stream + 0, 1, .., of one seed.
struct ShardStreams {
  std::uint64_t seed, first_stream;

  Pcg32 of(std::size_t shard) const { return Pcg32(seed, first_stream + shard); }
};

// `random` jitters the samples along the ray; base[kBaseChannels].
template <class T>
void place_ray(const StepSetting<T>& step, const TrainingRay& target, Pcg32& random, RaySamples<T>& ray,
               T* base) {
  const WindowFrame& frame = step.window.frame(target.frame);
  const ViewGeometry<T> view(step.window.frustum(), frame.T_anchor_camera);
  ray.count = step.samples_per_ray;
  ray.has_dynamic = step.has_dynamic;
  ray.warps = step.has_dynamic && target.warps;
  ray.toward = target.toward;
  place_samples(
      T(target.guide), ray.count, [&] { return random.uniform(); }, ray.inverse_depth, ray.spacing);
  const T pixel[2] = {T(target.pixel[0]), T(target.pixel[1])};
  fetch_base(frame.base, pixel, base);
  for (int k = 0; k < ray.count; ++k) view.place(pixel, ray.inverse_depth[k], ray.position[k]);
}

// The frame that a warping ray looks for its content in: its place in the window.
inline int neighbour_of(const TrainingRay& ray) { return neighbour_of(ray.frame, ray.toward); }

}  // namespace hdrcam
