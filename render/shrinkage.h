// Spatial shrinkage of a picture whose variance is known: 8x8 DCT tiles, overlapping by half, on the
// logarithm of radiance in opponent colours; each coefficient is scaled by max(0, 1 - 1.5 s^2 / c^2)
// (empirical Wiener filter), the tiles are averaged with more weight where fewer coefficients survive. For
// the output only: nothing here feeds back. Thread-bound.
#pragma once

#include <memory>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "hal/gpu/gpu_device.h"

namespace hdrcam {

class VulkanShrinkage;

class Shrinkage {
 public:
  // gpu: which shrinks, null for the processor; it outlives this. When it fails, the processor goes on.
  explicit Shrinkage(WorkerPool& pool, GpuDevice* gpu = nullptr);
  ~Shrinkage();

  // radiance, variance: [rgb, rows, cols]; offset: radiance below which a difference does not matter. Works
  // in place. Pictures smaller than one tile are unchanged.
  void apply(Image<float>& radiance, const Image<float>& variance, float offset);

 private:
  void apply_here(Image<float>& radiance, const Image<float>& variance, float offset);
  void give_up(const Error& why);

  WorkerPool& pool_;
  std::unique_ptr<VulkanShrinkage> gpu_;
  Image<float> opponent_, noise_, sum_, weight_;  // borrowed during a call
};

}  // namespace hdrcam
