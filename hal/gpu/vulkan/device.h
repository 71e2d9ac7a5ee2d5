// A Vulkan device opened for computing (hal/gpu/gpu_device.h). Thread-bound.
#pragma once

#include <map>

#include "hal/gpu/vulkan/instance.h"
#include "hal/gpu/vulkan/work.h"
#include "hal/storage.h"

namespace hdrcam::vulkan {

class Device final : public GpuDevice {
 public:
  static Result<std::unique_ptr<Device>> open(std::unique_ptr<Instance> instance, const PhysicalDevice& which,
                                              const std::string& cache_folder);
  ~Device() override;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const GpuFacts& facts() const override { return facts_; }
  Result<std::unique_ptr<GpuBuffer>> buffer(std::size_t bytes) override;
  Result<const GpuKernel*> kernel(const GpuShader& shader) override;
  GpuWork& work() override { return *work_; }
  // For tests of a driver that fails: they exchange one.
  DeviceFunctions& functions() { return vk_; }

 private:
  using Kernels = std::map<std::string, std::unique_ptr<Kernel>>;  // by the shader's name

  Device(std::unique_ptr<Instance> instance, const PhysicalDevice& which)
      : instance_(std::move(instance)), facts_(which.facts), limits_(which.properties.limits) {}
  Result<void> start(const PhysicalDevice& which, const std::string& cache_folder);
  void open_cache();
  void keep_cache();
  Result<void> compile(const GpuShader& shader, Kernel& kernel);
  void forsake();

  std::unique_ptr<Instance> instance_;
  GpuFacts facts_;
  VkPhysicalDeviceLimits limits_;
  VkDevice device_ = VK_NULL_HANDLE;
  DeviceFunctions vk_;
  std::unique_ptr<Memory> memory_;
  std::unique_ptr<Work> work_;
  Kernels kernels_;
  std::string cache_path_;
  VkPipelineCache cache_ = VK_NULL_HANDLE;
  std::size_t cached_bytes_ = 0;  // that were there at the start
};

}  // namespace hdrcam::vulkan
