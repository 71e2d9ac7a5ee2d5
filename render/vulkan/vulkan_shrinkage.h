// Shrinkage of a picture by its known variance (render/shrinkage.h) on a graphics device: tiles are shrunk
// and summed in runs that do not overlap, so in a fixed order; then each pixel gathers the weights of those
// that cover it. It takes the device's turn for each call. Thread-bound but for that; device and pool outlive
// it.
#pragma once

#include <array>

#include "hal/gpu/gpu_picture.h"
#include "render/shrinkage.h"

namespace hdrcam {

class VulkanShrinkage {
 public:
  static Result<std::unique_ptr<VulkanShrinkage>> make(GpuDevice& device, WorkerPool& pool);
  ~VulkanShrinkage();

  // As Shrinkage::apply; on an error the radiance is as it was. Errors: those of the device.
  Result<void> apply(Image<float>& radiance, const Image<float>& variance, const ShrinkageOptions& options);

 private:
  enum Pass : std::size_t { kOpponent, kShrink, kGather, kPasses };
  struct Tiles {  // tiles.glsl
    int rows, cols, tile_rows, tile_cols;
    ShrinkageGrid grid;
  };
  VulkanShrinkage(GpuDevice& device, WorkerPool& pool) : device_(device), pool_(pool) {}
  Result<void> reserve(int rows, int cols, int tile_rows, int tile_cols);
  void shrink(GpuWork& work, const Tiles& tiles, const ShrinkageThresholds& thresholds) const;

  GpuDevice& device_;
  WorkerPool& pool_;
  std::array<const GpuKernel*, kPasses> kernels_{};
  GpuPicture radiance_, variance_, opponent_, sums_, weights_;
};

}  // namespace hdrcam
