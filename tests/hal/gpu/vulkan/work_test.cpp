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
  QueueClock clock = {};
  DeviceFunctions vk = functions_of_driver();
  Memory memory{vk, VK_NULL_HANDLE, {}, 0};
  Work work{vk, VK_NULL_HANDLE, VK_NULL_HANDLE, memory, clock};
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

// How often one run of a kernel was timed, and with what time, by a queue whose count begins anew at 36 bits
// between its two ticks, which are 250 apart.
GpuStepTime timed_on(const QueueClock& clock) {
  Rig rig{.clock = clock};
  rig.vk.CreateQueryPool = [](VkDevice, const VkQueryPoolCreateInfo*, const VkAllocationCallbacks*,
                              VkQueryPool* pool) {
    *pool = reinterpret_cast<VkQueryPool>(&driver);
    return VK_SUCCESS;
  };
  rig.vk.DestroyQueryPool = [](VkDevice, VkQueryPool, const VkAllocationCallbacks*) {};
  rig.vk.CmdResetQueryPool = [](VkCommandBuffer, VkQueryPool, std::uint32_t, std::uint32_t) {};
  rig.vk.CmdWriteTimestamp = [](VkCommandBuffer, VkPipelineStageFlagBits, VkQueryPool, std::uint32_t) {};
  rig.vk.GetQueryPoolResults = [](VkDevice, VkQueryPool, std::uint32_t, std::uint32_t, std::size_t,
                                  void* data, VkDeviceSize, VkQueryResultFlags) {
    constexpr std::uint64_t kUndefined = std::uint64_t{5} << 60, kEnd = std::uint64_t{1} << 36;
    auto* const ticks = static_cast<std::uint64_t*>(data);
    ticks[0] = kUndefined + kEnd - 100, ticks[1] = 150;
    return VK_SUCCESS;
  };
  driver = {.full = false};
  GpuStepTimes times;
  rig.work.measure(&times);
  require_done(rig.done());
  return times[""];  // the kernel has no name
}

TEST_CASE("ticks count modulo the bits that the queue's clock has, and a queue without bits times nothing") {
  const GpuStepTime wrapped = timed_on({.tick_ns = 2, .bits = 36});
  CHECK(wrapped.times == 1);
  CHECK(wrapped.ms == Approx(250 * 2e-6));
  CHECK(timed_on({.tick_ns = 2, .bits = 0}).times == 0);
  CHECK(QueueClock{.tick_ns = 1, .bits = 64}.ms_between(3, std::uint64_t{1} << 40) ==
        Approx(1e-6 * ((std::uint64_t{1} << 40) - 3)));
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
