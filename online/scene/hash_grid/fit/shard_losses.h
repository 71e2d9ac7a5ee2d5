// The losses of one shard of a step's rays, added up in the order of the rays, wherever these are rendered.
// Scalar type T as in ../field/hash_grid.h. Value type, reentrant.
#pragma once

#include "online/scene/hash_grid/fit/step_setting.h"

namespace hdrcam {

template <class T>
struct ShardLosses {
  LossValues<T> losses{};                              // weighted, by LossTerm
  typename LearnedResponse<T>::Gradient d_response{};  // zero unless the step fits the response

  // Adds those of a ray and writes its gradient. Returns its photometric misfit, for the choice of pixels.
  float add(const StepSetting<T>& step, const TrainingRay& target, const RenderedRay<T>& ray,
            RayGradient<T>& gradient) {
    const LossSetting<T> setting{step.ray_share, step.weights, step.response,
                                 T(step.window.frame(target.frame).exposure)};
    gradient.clear(ray.samples.count);
    const LossValues<T> values =
        ray_losses(setting, target, ray, gradient, step.fits_response ? &d_response : nullptr);
    for (std::size_t term = 0; term < values.size(); ++term) losses[term] += values[term];
    return static_cast<float>(values[static_cast<std::size_t>(LossTerm::Combined)] / step.ray_share);
  }
};

}  // namespace hdrcam
