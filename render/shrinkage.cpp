#include "render/shrinkage.h"

#include <spdlog/spdlog.h>

#include <array>
#include <utility>

#include "render/shrinkage_kernels.h"
#include "render/vulkan/vulkan_shrinkage.h"

namespace hdrcam {
namespace {

using ThresholdTable = std::array<float, kShrinkageTile * kShrinkageTile>;

ThresholdTable table_of(const ShrinkageThresholds& thresholds, float scale) {
  constexpr std::size_t kTile = kShrinkageTile;
  ThresholdTable table;
  const auto risen = [&](std::size_t frequency) {
    return 1 + thresholds.rise * static_cast<float>(frequency) / (kTile - 1);
  };
  for (std::size_t k = 0; k < table.size(); ++k)
    table[k] = scale * thresholds.least * risen(k / kTile) * risen(k % kTile);
  return table;
}

}  // namespace

Shrinkage::Shrinkage(WorkerPool& pool, GpuDevice* gpu) : pool_(pool) {
  if (gpu == nullptr) return;
  auto made = VulkanShrinkage::make(*gpu, pool);
  if (made)
    gpu_ = std::move(*made);
  else
    fall_back_to_cpu(made.error());
}

Shrinkage::~Shrinkage() = default;

void Shrinkage::fall_back_to_cpu(const Error& why) {
  spdlog::warn("shrinkage goes on with the processor: {}", why.message);
  gpu_.reset();
}

void Shrinkage::apply(Image<float>& radiance, const Image<float>& variance, const ShrinkageOptions& options) {
  if (options.effort == ShrinkageEffort::Off) return;
  if (radiance.rows() < kShrinkageTile || radiance.cols() < kShrinkageTile) return;
  if (gpu_ != nullptr) {
    const Result<void> done = gpu_->apply(radiance, variance, options);
    if (done) return;
    fall_back_to_cpu(done.error());
  }
  apply_cpu(radiance, variance, options);
}

void Shrinkage::apply_cpu(Image<float>& radiance, const Image<float>& variance,
                          const ShrinkageOptions& options) {
  const ScratchLease room(pool_.scratch(), radiance.rows(), radiance.cols(),
                          {{&opponent_, 3}, {&noise_, 3}, {&sum_, 3}, {&weight_, 3}});
  to_opponent(radiance, variance, options.offset);
  shrink_tiles(thresholds_of(options.origin), grid_of(options.effort));
  to_radiance(options.offset, radiance);
}

void Shrinkage::to_opponent(const Image<float>& radiance, const Image<float>& variance, float offset) {
  pool_.for_rows(radiance.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      OpponentRow row{.radiance = {},
                      .variance = {},
                      .offset = offset,
                      .opponent = {},
                      .noise = {},
                      .sum = {},
                      .weight = {}};
      for (int c = 0; c < 3; ++c) {
        row.radiance[c] = radiance.row(c, y), row.variance[c] = variance.row(c, y);
        row.opponent[c] = opponent_.row(c, y), row.noise[c] = noise_.row(c, y);
        row.sum[c] = sum_.row(c, y), row.weight[c] = weight_.row(c, y);
      }
      shrinkage_kernels().to_opponent(row, radiance.cols());
    }
  });
}

void Shrinkage::shrink_tiles(const ShrinkageThresholds& thresholds, const ShrinkageGrid& grid) {
  const int rows = opponent_.rows(), cols = opponent_.cols();
  const ThresholdTable luminance = table_of(thresholds, 1), chroma = table_of(thresholds, thresholds.chroma);
  const int lines = grid.lines(rows), in_step = grid.lines_in_step(rows);
  const auto shrink = [&](int c, int line) {
    const int y = std::min(line * grid.line_step, rows - kShrinkageTile);
    const auto& table = c == 0 ? luminance : chroma;
    shrinkage_kernels().shrink({.opponent = opponent_.row(c, y),
                                .noise = noise_.row(c, y),
                                .thresholds = table.data(),
                                .first = line < lines - 1 ? line % 2 * grid.shift : 0,
                                .cols = cols,
                                .sum = sum_.row(c, y),
                                .weight = weight_.row(c, y)});
  };
  for (int pass = 0; pass < grid.passes(); ++pass)
    pool_.for_each(3 * grid.lines_of_pass(pass, rows),
                   [&](int i) { shrink(i % 3, i / 3 * grid.passes() + pass); });
  if (lines > in_step) pool_.for_each(3, [&](int c) { shrink(c, lines - 1); });
}

void Shrinkage::to_radiance(float offset, Image<float>& radiance) {
  pool_.for_rows(radiance.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      SmoothRow row{.sum = {}, .weight = {}, .offset = offset, .radiance = {}};
      for (int c = 0; c < 3; ++c) {
        row.sum[c] = sum_.row(c, y), row.weight[c] = weight_.row(c, y);
        row.radiance[c] = radiance.row(c, y);
      }
      shrinkage_kernels().to_radiance(row, radiance.cols());
    }
  });
}

}  // namespace hdrcam
