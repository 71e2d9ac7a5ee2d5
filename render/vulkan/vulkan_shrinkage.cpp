#include "render/vulkan/vulkan_shrinkage.h"

#include "render/vulkan/gather.comp.h"
#include "render/vulkan/opponent.comp.h"
#include "render/vulkan/shrink.comp.h"

namespace hdrcam {
namespace {

constexpr int kTile = 8, kStep = 4, kTileFloats = 65;  // tiles.glsl
constexpr float kMaxLogVariance = 0.25f;               // as shrinkage.cpp has it

int tiles_along(int pixels) { return (pixels - kTile + kStep - 1) / kStep + 1; }

struct Constants {
  int rows, cols, tile_rows, tile_cols;
  float offset, most_variance;
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

Result<void> VulkanShrinkage::reserve(int rows, int cols) {
  if (radiance_.rows == rows && radiance_.cols == cols) return {};
  radiance_ = TRY(GpuPicture::make(device_, 3, rows, cols));
  variance_ = TRY(GpuPicture::make(device_, 3, rows, cols));
  opponent_ = TRY(GpuPicture::make(device_, 6, rows, cols));
  tiles_ = TRY(GpuPicture::make(device_, 3, tiles_along(rows), tiles_along(cols) * kTileFloats));
  return {};
}

Result<void> VulkanShrinkage::apply(Image<float>& radiance, const Image<float>& variance, float offset,
                                    const ShrinkageThresholds& thresholds) {
  const std::lock_guard turn(device_.turn());
  const int rows = radiance.rows(), cols = radiance.cols();
  TRY(reserve(rows, cols));
  GpuWork& work = device_.work();
  const Constants constants{rows, cols, tiles_along(rows), tiles_along(cols), offset, kMaxLogVariance};
  upload(work, radiance, radiance_);
  upload(work, variance, variance_);
  work.run(*kernels_[kOpponent], {*radiance_, *variance_, *opponent_}, constants, radiance_.pixels());
  struct {
    int rows, cols, tile_rows, tile_cols;
    ShrinkageThresholds thresholds;
  } shrinking{rows, cols, constants.tile_rows, constants.tile_cols, thresholds};
  work.run(*kernels_[kShrink], {*opponent_, *tiles_}, shrinking,
           {constants.tile_cols, constants.tile_rows, 3});
  struct {
    int rows, cols, tile_rows, tile_cols;
    float offset;
  } gathering{rows, cols, constants.tile_rows, constants.tile_cols, offset};
  work.run(*kernels_[kGather], {*tiles_, *radiance_}, gathering, radiance_.pixels());
  download(work, radiance_, radiance);
  return work.finish();
}

}  // namespace hdrcam
