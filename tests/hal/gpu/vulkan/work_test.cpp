// Work on a driver that is not there: what is recorded after one of its calls failed.
#include "hal/gpu/vulkan/work.h"

#include "tests/contracts/expect.h"

#include <catch2/catch.hpp>

namespace hdrcam::vulkan {
namespace {

// Whether pools can be made, and whether the last set was taken from one that was.
struct Driver {
  bool full = true, set_of_pool = false;
} driver;

VkDescriptorPool a_pool() { return reinterpret_cast<VkDescriptorPool>(&driver); }

DeviceFunctions functions_of_driver() {
  DeviceFunctions vk;
  vk.CreateDescriptorPool = [](VkDevice, const VkDescriptorPoolCreateInfo*, const VkAllocationCallbacks*,
                               VkDescriptorPool* pool) {
    if (driver.full) return VK_ERROR_OUT_OF_HOST_MEMORY;
    *pool = a_pool();
    return VK_SUCCESS;
  };
  vk.AllocateDescriptorSets = [](VkDevice, const VkDescriptorSetAllocateInfo* info, VkDescriptorSet*) {
    driver.set_of_pool = info->descriptorPool == a_pool();
    return VK_SUCCESS;
  };
  vk.ResetDescriptorPool = [](VkDevice, VkDescriptorPool, VkDescriptorPoolResetFlags) { return VK_SUCCESS; };
  vk.DestroyDescriptorPool = [](VkDevice, VkDescriptorPool, const VkAllocationCallbacks*) {};
  vk.UpdateDescriptorSets = [](VkDevice, std::uint32_t, const VkWriteDescriptorSet*, std::uint32_t,
                               const VkCopyDescriptorSet*) {};
  vk.BeginCommandBuffer = [](VkCommandBuffer, const VkCommandBufferBeginInfo*) { return VK_SUCCESS; };
  vk.EndCommandBuffer = [](VkCommandBuffer) { return VK_SUCCESS; };
  vk.CmdBindPipeline = [](VkCommandBuffer, VkPipelineBindPoint, VkPipeline) {};
  vk.CmdBindDescriptorSets = [](VkCommandBuffer, VkPipelineBindPoint, VkPipelineLayout, std::uint32_t,
                                std::uint32_t, const VkDescriptorSet*, std::uint32_t,
                                const std::uint32_t*) {};
  vk.CmdPipelineBarrier = [](VkCommandBuffer, VkPipelineStageFlags, VkPipelineStageFlags, VkDependencyFlags,
                             std::uint32_t, const VkMemoryBarrier*, std::uint32_t,
                             const VkBufferMemoryBarrier*, std::uint32_t, const VkImageMemoryBarrier*) {};
  vk.CmdDispatch = [](VkCommandBuffer, std::uint32_t, std::uint32_t, std::uint32_t) {};
  vk.QueueSubmit = [](VkQueue, std::uint32_t, const VkSubmitInfo*, VkFence) { return VK_SUCCESS; };
  vk.WaitForFences = [](VkDevice, std::uint32_t, const VkFence*, VkBool32, std::uint64_t) {
    return VK_SUCCESS;
  };
  vk.ResetFences = [](VkDevice, std::uint32_t, const VkFence*) { return VK_SUCCESS; };
  return vk;
}

// Work on such a driver, and a kernel without buffers.
struct Rig {
  DeviceFunctions vk = functions_of_driver();
  Memory memory{vk, VK_NULL_HANDLE, {}, 0};
  Work work{vk, VK_NULL_HANDLE, VK_NULL_HANDLE, memory, 0};
  const Kernel kernel{vk, VK_NULL_HANDLE};

  Result<void> done() {
    work.run(kernel, std::span<const GpuBuffer* const>(), {}, {});
    return work.finish();
  }
};

TEST_CASE("after a driver had no memory to bind buffers, work takes none from a pool that was never made") {
  Rig rig;
  driver = {};
  require_error(rig.done(), ErrorCode::NoSpace);
  CHECK_FALSE(driver.set_of_pool);
  driver.full = false;
  require_done(rig.done());
  CHECK(driver.set_of_pool);
}

TEST_CASE("work that a driver has no memory to wait for may go on, and nothing more is handed over") {
  Rig rig;
  rig.vk.WaitForFences = [](VkDevice, std::uint32_t, const VkFence*, VkBool32, std::uint64_t) {
    return VK_ERROR_OUT_OF_HOST_MEMORY;
  };
  driver = {.full = false};
  require_error(rig.done(), ErrorCode::NoSpace);
  CHECK_FALSE(rig.work.answers());
  require_error(rig.done(), ErrorCode::Unplugged);
}

TEST_CASE("after a fence that could not be reset no work is taken for done that is not") {
  Rig rig;
  rig.vk.ResetFences = [](VkDevice, std::uint32_t, const VkFence*) { return VK_ERROR_OUT_OF_DEVICE_MEMORY; };
  driver = {.full = false};
  require_error(rig.done(), ErrorCode::NoSpace);
  CHECK(rig.work.answers());
  require_error(rig.done(), ErrorCode::Unplugged);
}

}  // namespace
}  // namespace hdrcam::vulkan
