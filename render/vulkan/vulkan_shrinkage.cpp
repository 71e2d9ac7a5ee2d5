#include "render/vulkan/vulkan_shrinkage.h"

#include "render/shrinkage_constants.h"
#include "render/vulkan/gather.comp.h"
#include "render/vulkan/opponent.comp.h"
#include "render/vulkan/shrink.comp.h"

namespace hdrcam {

Result<std::unique_ptr<VulkanShrinkage>> VulkanShrinkage::make(GpuDevice& device, WorkerPool& pool) {
  const std::array<GpuShader, kPasses> shaders{
      {{"opponent", k_opponent, 3}, {"shrink", k_shrink, 3}, {"gather", k_gather, 3}}};
  std::unique_ptr<VulkanShrinkage> made(new VulkanShrinkage(device, pool));
  const GpuTurn turn(device);  // ends before `made`, whose end takes a turn of its own
  made->kernels_ = TRY(kernels_of(device, shaders));
  return made;
}

VulkanShrinkage::~VulkanShrinkage() {
  const GpuTurn turn(device_);
  for (GpuPicture* picture : {&radiance_, &variance_, &opponent_, &sums_, &weights_}) picture->buffer.reset();
}

Result<void> VulkanShrinkage::reserve(int rows, int cols, int tile_rows, int tile_cols) {
  if (radiance_.rows != rows || radiance_.cols != cols) {
    radiance_ = TRY(GpuPicture::make(device_, 3, rows, cols));
    variance_ = TRY(GpuPicture::make(device_, 3, rows, cols));
    opponent_ = TRY(GpuPicture::make(device_, 6, rows, cols));
    sums_ = TRY(GpuPicture::make(device_, 3, rows, cols));
    weights_ = {};
  }
  if (weights_.rows < tile_rows) weights_ = TRY(GpuPicture::make(device_, 3, tile_rows, tile_cols));
  return {};
}

void VulkanShrinkage::shrink(GpuWork& work, const Tiles& tiles, const ShrinkageThresholds& thresholds) const {
  const int in_step = tiles.grid.lines_in_step(tiles.rows), passes = tiles.grid.passes();
  const auto run = [&](int first_line, int line_stride, int lines) {
    for (int part = 0; part < 3; ++part) {
      const struct {
        Tiles tiles;
        ShrinkageThresholds thresholds;
        int first_line, line_stride, part;
      } shrinking{tiles, thresholds, first_line, line_stride, part};
      work.run(*kernels_[kShrink], {*opponent_, *sums_, *weights_}, shrinking,
               {part < 2 ? (tiles.tile_cols + 1) / 2 : 1, lines, 3});
    }
  };
  for (int pass = 0; pass < std::min(passes, in_step); ++pass)
    run(pass, passes, tiles.grid.lines_of_pass(pass, tiles.rows));
  if (tiles.tile_rows > in_step) run(in_step, 1, 1);
}

Result<void> VulkanShrinkage::apply(Image<float>& radiance, const Image<float>& variance,
                                    const ShrinkageOptions& options) {
  const GpuTurn turn(device_, &pool_);
  const int rows = radiance.rows(), cols = radiance.cols();
  const ShrinkageGrid grid = grid_of(options.effort);
  const Tiles tiles{rows, cols, grid.lines(rows), grid.columns(cols), grid};
  TRY(reserve(rows, cols, tiles.tile_rows, tiles.tile_cols));
  GpuWork& work = device_.work();
  upload(work, radiance, radiance_);
  upload(work, variance, variance_);
  struct {
    Tiles tiles;
    float offset, most_variance;
  } in_opponent_colours{tiles, options.offset, kMaxLogVariance};
  work.run(*kernels_[kOpponent], {*radiance_, *variance_, *opponent_}, in_opponent_colours,
           radiance_.pixels());
  work.clear(*sums_.buffer);
  shrink(work, tiles, thresholds_of(options.origin));
  struct {
    Tiles tiles;
    float offset;
  } gathering{tiles, options.offset};
  work.run(*kernels_[kGather], {*sums_, *weights_, *radiance_}, gathering, radiance_.pixels());
  download(work, radiance_, radiance);
  return work.finish();
}

}  // namespace hdrcam
