#include "render/vulkan/vulkan_shrinkage.h"

#include "render/shrinkage_constants.h"
#include "render/vulkan/gather.comp.h"
#include "render/vulkan/opponent.comp.h"
#include "render/vulkan/shrink.comp.h"

namespace hdrcam {
namespace {

constexpr int kTileFloats = kShrinkageTile * kShrinkageTile + 1;  // tiles.glsl

int tiles_along(int pixels, int step) { return (pixels - kShrinkageTile + step - 1) / step + 1; }

struct TileConstants {
  int rows, cols, tile_rows, tile_cols;
  ShrinkageGrid grid;
};

}  // namespace

Result<std::unique_ptr<VulkanShrinkage>> VulkanShrinkage::make(GpuDevice& device) {
  const std::lock_guard turn(device.turn());
  const std::array<GpuShader, kPasses> shaders{
      {{"opponent", k_opponent, 3}, {"shrink", k_shrink, 2}, {"gather", k_gather, 2}}};
  std::unique_ptr<VulkanShrinkage> made(new VulkanShrinkage(device));
  for (std::size_t i = 0; i < kPasses; ++i) made->kernels_[i] = TRY(device.kernel(shaders[i]));
  return made;
}

Result<void> VulkanShrinkage::reserve(int rows, int cols, int tile_rows, int tile_cols) {
  if (radiance_.rows != rows || radiance_.cols != cols) {
    radiance_ = TRY(GpuPicture::make(device_, 3, rows, cols));
    variance_ = TRY(GpuPicture::make(device_, 3, rows, cols));
    opponent_ = TRY(GpuPicture::make(device_, 6, rows, cols));
    tiles_ = {};
  }
  if (tiles_.rows < tile_rows) tiles_ = TRY(GpuPicture::make(device_, 3, tile_rows, tile_cols * kTileFloats));
  return {};
}

Result<void> VulkanShrinkage::apply(Image<float>& radiance, const Image<float>& variance,
                                    const ShrinkageOptions& options) {
  const std::lock_guard turn(device_.turn());
  const int rows = radiance.rows(), cols = radiance.cols();
  const ShrinkageGrid grid = grid_of(options.effort);
  const TileConstants tiles{rows, cols, tiles_along(rows, grid.line_step), tiles_along(cols, kShrinkageStep),
                            grid};
  TRY(reserve(rows, cols, tiles.tile_rows, tiles.tile_cols));
  GpuWork& work = device_.work();
  upload(work, radiance, radiance_);
  upload(work, variance, variance_);
  struct {
    TileConstants tiles;
    float offset, most_variance;
  } in_opponent_colours{tiles, options.offset, kMaxLogVariance};
  work.run(*kernels_[kOpponent], {*radiance_, *variance_, *opponent_}, in_opponent_colours,
           radiance_.pixels());
  struct {
    TileConstants tiles;
    ShrinkageThresholds thresholds;
  } shrinking{tiles, thresholds_of(options.origin)};
  work.run(*kernels_[kShrink], {*opponent_, *tiles_}, shrinking, {tiles.tile_cols, tiles.tile_rows, 3});
  struct {
    TileConstants tiles;
    float offset;
  } gathering{tiles, options.offset};
  work.run(*kernels_[kGather], {*tiles_, *radiance_}, gathering, radiance_.pixels());
  download(work, radiance_, radiance);
  return work.finish();
}

}  // namespace hdrcam
