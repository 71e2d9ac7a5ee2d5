// The kernels of the fit, one call each: a call records a step of the device's work. Thread-bound; the device
// outlives them.
#pragma once

#include <array>

#include "online/scene/hash_grid/fit/vulkan/gpu_rays.h"

namespace hdrcam {

struct SampleRange {
  int first, count;  // count > 0
};

class FitPasses {
 public:
  // Errors: those of the device.
  static Result<FitPasses> make(GpuDevice& device);

  // features and raw outputs of samples, where they are placed
  void forward(const GpuBranch& branch, const GpuRays& rays, SampleRange samples) const;
  // displaced samples from placed ones, along the scene flow in `raw`
  void follow(const GpuRays& rays) const;
  // seen from raw
  void render(const GpuRays& rays) const;
  // d_raw from d_seen, the gradient of render()
  void composite_backward(const GpuRays& rays) const;
  // d_features from d_raw, and the parts of the parameters' gradient
  void backward(const GpuBranch& branch, const GpuRays& rays, SampleRange samples) const;
  // d_raw of the scene flow += that of the displaced samples: the gradient of follow()
  void warp_backward(const GpuBranch& dynamic, const GpuRays& rays) const;
  // d_network, energy and peaks over samples 0 .. count - 1
  void add_up(const GpuBranch& branch, int ld, int count) const;
  // the tables' gradient from d_features and peaks
  void scatter(const GpuBranch& branch, const GpuRays& rays, int count) const;
  // a step on the parameters; clears the tables' gradient of `count` samples
  void adam(const GpuBranch& branch, const AdamStep& table_step, const AdamStep& network_step,
            int count) const;

 private:
  enum Pass : std::size_t {
    kEncode,
    kNetwork,
    kFollow,
    kRender,
    kCompositeBackward,
    kBackward,
    kWarpBackward,
    kOuter,
    kSum,
    kMeasure,
    kScatter,
    kAdamTable,
    kAdamNetwork,
    kPasses
  };
  explicit FitPasses(GpuDevice& device) : device_(&device) {}

  GpuDevice* device_;
  std::array<const GpuKernel*, kPasses> kernels_{};
};

}  // namespace hdrcam
