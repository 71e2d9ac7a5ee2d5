// The objective of the fit (paper section 4.4 and appendix): for one ray the weighted sum of its losses,
// reported by name, with the gradients with respect to the ray's picture and its samples. Scalar type T as in
// ../field/hash_grid.h.
// Reentrant.
#pragma once

#include <algorithm>

#include "online/scene/hash_grid/field/ray_rendering.h"
#include "online/scene/hash_grid/fit/learned_response.h"
#include "online/scene/hash_grid/fit/loss_table.h"
#include "online/scene/hash_grid/fit/losses/blend_entropy.h"
#include "online/scene/hash_grid/fit/losses/cycle.h"
#include "online/scene/hash_grid/fit/losses/depth.h"
#include "online/scene/hash_grid/fit/losses/distortion.h"
#include "online/scene/hash_grid/fit/losses/flow.h"
#include "online/scene/hash_grid/fit/losses/minimal_flow.h"
#include "online/scene/hash_grid/fit/losses/occlusion.h"
#include "online/scene/hash_grid/fit/losses/photometric.h"
#include "online/scene/hash_grid/fit/losses/radiance_consistency.h"
#include "online/scene/hash_grid/fit/losses/spatial_smoothness.h"
#include "online/scene/hash_grid/fit/losses/state_supervision.h"
#include "online/scene/hash_grid/fit/losses/temporal_smoothness.h"
#include "online/scene/hash_grid/fit/losses/warped_photometric.h"

namespace hdrcam {

// The target of a ray: the measurements and priors of one pixel of one frame.
struct TrainingRay {
  int frame = 0;  // position in the window
  float pixel[2] = {0, 0};
  bool warps = false;  // there is a neighbour in the direction `toward`
  Neighbour toward = Neighbour::Next;
  float guide = 0;              // inverse depth around which samples are placed
  float values[3] = {0, 0, 0};  // measured, 0..1, or kNoValue
  float sharpness = 1;  // 1 / (1 + motion blur in pixels^2): the codes are an integral, the field is not
  float state_log_radiance[3] = {0, 0, 0}, state_trust[3] = {0, 0, 0};
  float flow_prior[2] = {0, 0}, flow_confidence = 0;  // pixel of the neighbour
  float depth_prior = 0, depth_confidence = 0;
};

// What the losses of a ray are taken with; borrowed for the call.
template <class T>
struct LossSetting {
  T share;  // of the ray in the objective: one over the rays of the step
  const LossWeights& weights;
  const LearnedResponse<T>& response;
  T exposure;  // of the ray's frame, relative to the reference

  T weight(LossTerm term) const { return share * T(weights[static_cast<std::size_t>(term)]); }
};

// A ray as it was rendered; borrowed for the call.
template <class T>
struct RenderedRay {
  const RaySamples<T>& samples;
  const RayTrace<T>& trace;
  const RayPicture<T>& picture;
};

// The gradient of a ray's losses with respect to what was rendered. Of the samples it has the FieldSamples
// alone.
template <class T>
struct RayGradient {
  RaySamples<T> samples;
  T weight[kMaxSamples] = {};  // of the combined trace
  RayPicture<T> picture;

  // To zero, for a ray of `count` samples.
  void clear(int count) {
    const FieldSample<T> none;
    for (FieldSample<T>* of : {samples.static_, samples.dynamic, samples.static_there, samples.warped})
      std::fill_n(of, count, none);
    std::fill_n(weight, count, T(0));
    picture = {};
  }
};

// The terms on the scene flow of all samples: means over samples and, where both neighbours count, over
// directions.
template <class T>
void flow_regularisers(const LossSetting<T>& setting, const RaySamples<T>& ray, LossValues<T>& values,
                       RaySamples<T>& d_ray) {
  const auto weight = [&](LossTerm term) { return setting.weight(term) / T(ray.count); };
  const auto value = [&](LossTerm term) -> T& { return values[static_cast<std::size_t>(term)]; };
  for (int k = 0; k < ray.count; ++k) {
    const FieldSample<T>& here = ray.dynamic[k];
    FieldSample<T>& d_here = d_ray.dynamic[k];
    value(LossTerm::TemporalSmoothness) += temporal_smoothness_loss(
        weight(LossTerm::TemporalSmoothness), here.flow[0], here.flow[1], d_here.flow[0], d_here.flow[1]);
    for (int n = 0; n < 2; ++n)
      value(LossTerm::MinimalFlow) += minimal_flow_loss(weight(LossTerm::MinimalFlow) / 2,
                                                        here.flow_residual[n], d_here.flow_residual[n]);
    if (k + 1 == ray.count) continue;
    T squared = 0;
    for (int a = 0; a < 3; ++a) {
      const T apart = ray.position[k + 1][a] - ray.position[k][a];
      squared += apart * apart;
    }
    for (int n = 0; n < 2; ++n)
      value(LossTerm::SpatialSmoothness) +=
          spatial_smoothness_loss(weight(LossTerm::SpatialSmoothness) / 2, std::sqrt(squared), here.flow[n],
                                  ray.dynamic[k + 1].flow[n], d_here.flow[n], d_ray.dynamic[k + 1].flow[n]);
  }
}

// The terms that compare a ray with the neighbour that it warps to.
template <class T>
void neighbour_losses(const LossSetting<T>& setting, const TrainingRay& target,
                      const RenderedRay<T>& rendered, LossValues<T>& values, RayGradient<T>& gradient) {
  const RaySamples<T>& ray = rendered.samples;
  const RayPicture<T>& picture = rendered.picture;
  RaySamples<T>& d_ray = gradient.samples;
  RayPicture<T>& d_picture = gradient.picture;
  const auto weight = [&](LossTerm term) { return setting.weight(term); };
  const auto value = [&](LossTerm term) -> T& { return values[static_cast<std::size_t>(term)]; };

  value(LossTerm::Warped) += warped_photometric_loss(
      weight(LossTerm::Warped) * T(target.sharpness), setting.response, setting.exposure,
      picture.warped_radiance, target.values, picture.visible, d_picture.warped_radiance, d_picture.visible);
  value(LossTerm::Occlusion) +=
      occlusion_loss(weight(LossTerm::Occlusion), picture.visible, d_picture.visible);
  const T prior[2] = {T(target.flow_prior[0]), T(target.flow_prior[1])};
  value(LossTerm::Flow) += flow_loss(weight(LossTerm::Flow) * T(target.flow_confidence), picture.landing,
                                     prior, d_picture.landing);
  value(LossTerm::Consistency) += radiance_consistency_loss(
      weight(LossTerm::Consistency) * T(target.flow_confidence), picture.visible, picture.radiance,
      picture.warped_radiance, d_picture.radiance, d_picture.warped_radiance, d_picture.visible);
  const int there = static_cast<int>(ray.toward), back = 1 - there;
  for (int k = 0; k < ray.count; ++k)
    value(LossTerm::Cycle) +=
        cycle_loss(weight(LossTerm::Cycle) / T(ray.count), ray.dynamic[k].flow[there],
                   ray.warped[k].flow[back], ray.dynamic[k].occlusion[there], d_ray.dynamic[k].flow[there],
                   d_ray.warped[k].flow[back], d_ray.dynamic[k].occlusion[there]);
}

// Losses of one ray by term, each weighted and times its share. Adds to the gradient of the picture, of the
// samples' flows and occlusions, and of the ray's weights, and, if not null, to that of the response.
template <class T>
LossValues<T> ray_losses(const LossSetting<T>& setting, const TrainingRay& target,
                         const RenderedRay<T>& rendered, RayGradient<T>& gradient,
                         typename LearnedResponse<T>::Gradient* d_response) {
  const RaySamples<T>& ray = rendered.samples;
  const RayPicture<T>& picture = rendered.picture;
  RaySamples<T>& d_ray = gradient.samples;
  RayPicture<T>& d_picture = gradient.picture;
  LossValues<T> values{};
  const auto weight = [&](LossTerm term) { return setting.weight(term); };
  const auto value = [&](LossTerm term) -> T& { return values[static_cast<std::size_t>(term)]; };

  value(LossTerm::Combined) +=
      photometric_loss(weight(LossTerm::Combined) * T(target.sharpness), setting.response, setting.exposure,
                       picture.radiance, target.values, d_picture.radiance, d_response);
  const T state[3] = {T(target.state_log_radiance[0]), T(target.state_log_radiance[1]),
                      T(target.state_log_radiance[2])};
  const T trust[3] = {T(target.state_trust[0]), T(target.state_trust[1]), T(target.state_trust[2])};
  value(LossTerm::State) +=
      state_loss(weight(LossTerm::State), picture.radiance, state, trust, d_picture.radiance);
  if (target.depth_confidence > 0)
    value(LossTerm::Depth) +=
        depth_loss(weight(LossTerm::Depth) * T(target.depth_confidence), picture.inverse_depth,
                   T(target.depth_prior), d_picture.inverse_depth);
  if (ray.count > 1)
    value(LossTerm::Distortion) +=
        distortion_loss(weight(LossTerm::Distortion), ray.count, rendered.trace.combined.weight,
                        ray.inverse_depth, gradient.weight);
  if (!ray.has_dynamic) return values;
  value(LossTerm::BlendEntropy) +=
      blend_entropy_loss(weight(LossTerm::BlendEntropy), picture.share, d_picture.share);
  flow_regularisers(setting, ray, values, d_ray);
  if (ray.warps) neighbour_losses(setting, target, rendered, values, gradient);
  return values;
}

}  // namespace hdrcam
