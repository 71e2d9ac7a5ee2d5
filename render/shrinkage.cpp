#include "render/shrinkage.h"

#include <spdlog/spdlog.h>

#include <array>
#include <utility>

#include "render/shrinkage_kernels.h"
#include "render/vulkan/vulkan_shrinkage.h"

namespace hdrcam {
namespace {

template <class Picture>
auto rows_of(Picture& picture, int y) {
  return std::array{picture.row(0, y), picture.row(1, y), picture.row(2, y)};
}

using ThresholdTable = std::array<float, kShrinkageTile * kShrinkageTile>;

ThresholdTable table_of(const ShrinkageThresholds& thresholds, float scale) {
  ThresholdTable table;
  const auto risen = [&](int frequency) {
    return 1 + thresholds.rise * static_cast<float>(frequency) / (kShrinkageTile - 1);
  };
  for (int i = 0; i < kShrinkageTile; ++i)
    for (int j = 0; j < kShrinkageTile; ++j)
      table[static_cast<std::size_t>(kShrinkageTile * i + j)] =
          scale * thresholds.least * risen(i) * risen(j);
  return table;
}

}  // namespace

Shrinkage::Shrinkage(WorkerPool& pool, GpuDevice* gpu) : pool_(pool) {
  if (gpu == nullptr) return;
  auto made = VulkanShrinkage::make(*gpu);
  if (made)
    gpu_ = std::move(*made);
  else
    give_up(made.error());
}

Shrinkage::~Shrinkage() = default;

void Shrinkage::give_up(const Error& why) {
  spdlog::warn("shrinkage goes on with the processor: {}", why.message);
  gpu_.reset();
}

void Shrinkage::apply(Image<float>& radiance, const Image<float>& variance, float offset,
                      NoiseOrigin origin) {
  if (radiance.rows() < kShrinkageTile || radiance.cols() < kShrinkageTile) return;
  const ShrinkageThresholds thresholds = thresholds_of(origin);
  if (gpu_ != nullptr) {
    const Result<void> done = gpu_->apply(radiance, variance, offset, thresholds);
    if (done) return;
    give_up(done.error());
  }
  apply_here(radiance, variance, offset, thresholds);
}

void Shrinkage::apply_here(Image<float>& radiance, const Image<float>& variance, float offset,
                           const ShrinkageThresholds& thresholds) {
  const ShrinkageKernels& kernels = shrinkage_kernels();
  const int rows = radiance.rows(), cols = radiance.cols();
  const Borrowed room(pool_.scratch(), rows, cols,
                      {{&opponent_, 3}, {&noise_, 3}, {&sum_, 3}, {&weight_, 3}});

  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      kernels.to_opponent(rows_of(std::as_const(radiance), y).data(), rows_of(variance, y).data(), offset,
                          cols, rows_of(opponent_, y).data(), rows_of(noise_, y).data(),
                          rows_of(sum_, y).data(), rows_of(weight_, y).data());
  });

  const ThresholdTable luminance = table_of(thresholds, 1), chroma = table_of(thresholds, thresholds.chroma);
  // Tile rows two steps apart do not overlap: two passes of independent rows, then the last row if it is out
  // of step.
  const auto shrink = [&](int channel, int y) {
    const auto& table = channel == 0 ? luminance : chroma;
    kernels.shrink(opponent_.row(channel, y), noise_.row(channel, y), table.data(), cols,
                   sum_.row(channel, y), weight_.row(channel, y));
  };
  const int tile_rows = (rows - kShrinkageTile) / kShrinkageStep + 1;
  for (int parity = 0; parity < 2; ++parity)
    pool_.for_each((tile_rows + 1 - parity) / 2 * 3,
                   [&](int i) { shrink(i % 3, (i / 3 * 2 + parity) * kShrinkageStep); });
  if ((rows - kShrinkageTile) % kShrinkageStep != 0)
    pool_.for_each(3, [&](int c) { shrink(c, rows - kShrinkageTile); });

  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      kernels.to_radiance(rows_of(std::as_const(sum_), y).data(), rows_of(std::as_const(weight_), y).data(),
                          offset, cols, rows_of(radiance, y).data());
  });
}

}  // namespace hdrcam
