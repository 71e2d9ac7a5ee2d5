// The functions of Vulkan that we call, found at run time. Three levels, as Vulkan has them: the loader's, an
// instance's and a device's. Plain tables of pointers; only files of this folder include this.
#pragma once

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

#include "hal/core/result.h"

namespace hdrcam::vulkan {

// clang-format off
#define HDRCAM_INSTANCE_FUNCTIONS(X) \
  X(DestroyInstance) X(EnumeratePhysicalDevices) X(GetPhysicalDeviceProperties2) \
  X(GetPhysicalDeviceMemoryProperties) X(GetPhysicalDeviceQueueFamilyProperties) X(CreateDevice) \
  X(GetDeviceProcAddr)

#define HDRCAM_DEVICE_FUNCTIONS(X) \
  X(DestroyDevice) X(GetDeviceQueue) X(DeviceWaitIdle) X(AllocateMemory) X(FreeMemory) X(MapMemory) \
  X(CreateBuffer) X(DestroyBuffer) X(GetBufferMemoryRequirements) X(BindBufferMemory) \
  X(CreateShaderModule) X(DestroyShaderModule) X(CreateDescriptorSetLayout) \
  X(DestroyDescriptorSetLayout) X(CreatePipelineLayout) X(DestroyPipelineLayout) \
  X(CreateComputePipelines) X(DestroyPipeline) X(CreatePipelineCache) X(DestroyPipelineCache) \
  X(GetPipelineCacheData) X(CreateDescriptorPool) X(DestroyDescriptorPool) X(ResetDescriptorPool) \
  X(AllocateDescriptorSets) X(UpdateDescriptorSets) X(CreateCommandPool) X(DestroyCommandPool) \
  X(AllocateCommandBuffers) X(BeginCommandBuffer) X(EndCommandBuffer) X(CmdBindPipeline) \
  X(CmdBindDescriptorSets) X(CmdPushConstants) X(CmdDispatch) X(CmdCopyBuffer) X(CmdFillBuffer) \
  X(CmdPipelineBarrier) X(CmdResetQueryPool) X(CmdWriteTimestamp) X(CreateQueryPool) X(DestroyQueryPool) \
  X(GetQueryPoolResults) X(CreateFence) X(DestroyFence) X(ResetFences) X(WaitForFences) X(QueueSubmit)
// clang-format on

struct InstanceFunctions {
#define HDRCAM_MEMBER(name) PFN_vk##name name = nullptr;
  HDRCAM_INSTANCE_FUNCTIONS(HDRCAM_MEMBER)
};
struct DeviceFunctions {
  HDRCAM_DEVICE_FUNCTIONS(HDRCAM_MEMBER)
#undef HDRCAM_MEMBER
};

// The loader's entry.
struct Loader {
  PFN_vkGetInstanceProcAddr get;
};
// NotFound where no loader is installed. Never closed: drivers leave something behind on each thread that has
// used them.
Result<Loader> loader();
InstanceFunctions instance_functions(PFN_vkGetInstanceProcAddr get, VkInstance instance);
DeviceFunctions device_functions(PFN_vkGetDeviceProcAddr get, VkDevice device);

// What a failed call means to us; doing: "making a buffer of 3 MiB".
Error failed(VkResult result, const std::string& doing);

}  // namespace hdrcam::vulkan
