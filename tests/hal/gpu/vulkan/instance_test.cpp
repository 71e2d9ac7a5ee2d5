#include "hal/gpu/vulkan/instance.h"

#include <catch2/catch.hpp>

namespace hdrcam::vulkan {

TEST_CASE("a graphics device that lacks what kernels need is told from one that has it") {
  VkPhysicalDeviceProperties device{};
  device.apiVersion = VK_API_VERSION_1_1;
  device.limits.maxPerStageDescriptorStorageBuffers = kMostKernelBuffers;
  device.limits.maxDescriptorSetStorageBuffers = kMostKernelBuffers;
  CHECK(what_is_missing(device, true).empty());
  CHECK(what_is_missing(device, false).find("no queue") != std::string::npos);
  device.limits.maxPerStageDescriptorStorageBuffers = 8;
  CHECK(what_is_missing(device, true).find("use 8 buffers, 9 are needed") != std::string::npos);
  device.apiVersion = VK_API_VERSION_1_0;
  CHECK(what_is_missing(device, true).find("Vulkan 1.0.0, 1.1 is needed") != std::string::npos);
}

}  // namespace hdrcam::vulkan
