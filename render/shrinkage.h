// Spatial shrinkage of a picture whose variance is known: overlapping 8x8 DCT tiles on the logarithm of
// radiance in opponent colours; each coefficient is scaled by max(0, 1 - t s^2 / c^2) (empirical Wiener
// filter), the tiles are averaged with more weight where fewer coefficients survive. The threshold t goes by
// where the noise comes from. For the output only: nothing here feeds back. Thread-bound.
#pragma once

#include <memory>

#include "capture/noise_model.h"
#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "hal/gpu/gpu_device.h"
#include "online/frame_budget.h"
#include "render/shrinkage_constants.h"

namespace hdrcam {

class VulkanShrinkage;

// The thresholds of a picture's coefficients. Of frequencies i and j (0..7): least (1 + rise i / 7) (1 + rise
// j / 7), of both chroma channels that times `chroma`. What neighbours share stays in the mean of many
// frames, whose variance then says too little, and most of it at high frequencies and in chroma, which a
// camera has smoothed and then halved.
struct ShrinkageThresholds {
  float least, rise, chroma;
};
constexpr ShrinkageThresholds thresholds_of(NoiseOrigin origin) {
  return origin == NoiseOrigin::Sensor ? ShrinkageThresholds{0.9f, 0, 1} : ShrinkageThresholds{1.4f, 1, 1.5f};
}

// Lines of tiles begin every `line_step` rows, tiles of a line every 4 pixels, in every other line but the
// last `shift` pixels later. The last of either ends with the picture.
struct ShrinkageGrid {
  int line_step, shift;

  // Of a picture of at least one tile.
  constexpr int lines(int rows) const { return tiles_along(rows, line_step); }
  constexpr int columns(int cols) const { return tiles_along(cols, kShrinkageStep); }  // of unshifted lines
  // Those that begin at a multiple of the step: all lines, or all but the last.
  constexpr int lines_in_step(int rows) const { return (rows - kShrinkageTile) / line_step + 1; }
  // Lines that are a tile apart do not overlap: pass i of so many has the lines i, i + passes(), .. in step.
  constexpr int passes() const { return kShrinkageTile / line_step; }
  constexpr int lines_of_pass(int pass, int rows) const {
    return (lines_in_step(rows) - pass + passes() - 1) / passes();
  }

 private:
  static constexpr int tiles_along(int pixels, int step) {
    return (pixels - kShrinkageTile + step - 1) / step + 1;
  }
};
constexpr ShrinkageGrid grid_of(ShrinkageEffort effort) {
  return effort == ShrinkageEffort::Dense ? ShrinkageGrid{2, 2} : ShrinkageGrid{4, 0};
}

struct ShrinkageOptions {
  float offset;  // radiance below which a difference does not matter
  NoiseOrigin origin = NoiseOrigin::Unknown;
  ShrinkageEffort effort = ShrinkageEffort::On;
};

class Shrinkage {
 public:
  // gpu: which shrinks, null for the processor; it outlives this. When it fails, the processor goes on.
  explicit Shrinkage(WorkerPool& pool, GpuDevice* gpu = nullptr);
  ~Shrinkage();

  // radiance, variance: [rgb, rows, cols]. Works in place. Pictures smaller than one tile are unchanged.
  void apply(Image<float>& radiance, const Image<float>& variance, const ShrinkageOptions& options);

 private:
  void apply_cpu(Image<float>& radiance, const Image<float>& variance, const ShrinkageOptions& options);
  // The steps of apply_cpu(), in their order; between them the picture is in the borrowed planes.
  void to_opponent(const Image<float>& radiance, const Image<float>& variance, float offset);
  void shrink_tiles(const ShrinkageThresholds& thresholds, const ShrinkageGrid& grid);
  void to_radiance(float offset, Image<float>& radiance);
  void fall_back_to_cpu(const Error& why);

  WorkerPool& pool_;
  std::unique_ptr<VulkanShrinkage> gpu_;
  Image<float> opponent_, noise_, sum_, weight_;  // [opponent colours, rows, cols], borrowed during a call
};

}  // namespace hdrcam
