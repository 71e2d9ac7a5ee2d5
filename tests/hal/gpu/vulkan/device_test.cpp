// A real device with a driver that fails: one of its calls is exchanged.
#include "hal/gpu/vulkan/device.h"

#include "online/pictures/vulkan/box_mean.comp.h"
#include "tests/support/gpu.h"

#include "tests/contracts/expect.h"

namespace hdrcam::vulkan {
namespace {

const GpuShader kBoxMean{"box_mean", k_box_mean, 2};

// Null where there is no graphics device.
std::unique_ptr<Device> open_device() {
  auto instance = Instance::open(nullptr);
  if (!instance) return nullptr;
  for (const PhysicalDevice& one : (*instance)->devices())
    if (one.facts.missing.empty()) return value_of(Device::open(std::move(*instance), one, ""));
  return nullptr;
}

TEST_CASE("a kernel that the driver could not make is an error each time, and the device goes on and ends",
          "[gpu]") {
  const auto device = open_device();
  NEEDS_GPU(device);
  const auto really = device->functions().CreateComputePipelines;
  device->functions().CreateComputePipelines =
      [](VkDevice, VkPipelineCache, std::uint32_t, const VkComputePipelineCreateInfo*,
         const VkAllocationCallbacks*, VkPipeline*) { return VK_ERROR_OUT_OF_HOST_MEMORY; };
  for (int i = 0; i < 2; ++i) require_error(device->kernel(kBoxMean), ErrorCode::NoSpace);
  device->functions().CreateComputePipelines = really;
  CHECK(device->kernel(kBoxMean).ok());
  device->functions().CreateComputePipelines = nullptr;
  CHECK(device->kernel(kBoxMean).ok());  // kept
}

int waits_for_idle = 0;

TEST_CASE("a graphics device that does not answer is lost, and the program's end does not wait for it",
          "[gpu]") {
  auto device = open_device();
  NEEDS_GPU(device);
  waits_for_idle = 0;
  device->functions().WaitForFences = [](VkDevice, std::uint32_t, const VkFence*, VkBool32, std::uint64_t) {
    return VK_TIMEOUT;
  };
  device->functions().DeviceWaitIdle = [](VkDevice) { return ++waits_for_idle, VK_SUCCESS; };
  auto buffer = value_of(device->buffer(64));
  device->work().clear(*buffer);
  require_error(device->work().finish(), ErrorCode::Timeout);
  device->work().clear(*buffer);
  require_error(device->work().finish(), ErrorCode::Unplugged);
  buffer.reset();
  device.reset();
  CHECK(waits_for_idle == 0);
}

}  // namespace
}  // namespace hdrcam::vulkan
