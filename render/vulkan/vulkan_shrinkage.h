// Shrinkage of a picture by its known variance (render/shrinkage.h) on a graphics device: tiles are shrunk
// side by side, then each pixel gathers those that cover it, in a fixed order. It takes the device's turn for
// each call. Thread-bound but for that; the device outlives it.
#pragma once

#include <array>

#include "hal/gpu/gpu_picture.h"
#include "render/shrinkage.h"

namespace hdrcam {

class VulkanShrinkage {
 public:
  static Result<std::unique_ptr<VulkanShrinkage>> make(GpuDevice& device);

  // As Shrinkage::apply; on an error the radiance is as it was. Errors: those of the device.
  Result<void> apply(Image<float>& radiance, const Image<float>& variance, const ShrinkageOptions& options);

 private:
  enum Pass : std::size_t { kOpponent, kShrink, kGather, kPasses };
  explicit VulkanShrinkage(GpuDevice& device) : device_(device) {}
  Result<void> reserve(int rows, int cols, int tile_rows, int tile_cols);

  GpuDevice& device_;
  std::array<const GpuKernel*, kPasses> kernels_{};
  GpuPicture radiance_, variance_, opponent_, tiles_;
};

}  // namespace hdrcam
