// Memory of one device in a few large blocks, of which buffers are ranges: drivers allow some thousands of
// allocations only, and each takes long. First fit; what is given back joins its free neighbours. The device
// outlives the memory, the memory its ranges. Thread-bound.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "hal/gpu/gpu_device.h"
#include "hal/gpu/vulkan/functions.h"

namespace hdrcam::vulkan {

enum class MemoryUse {
  Compute,  // the device's own: kernels read and write it
  Staging,  // seen by the processor, mapped: on the way in or out
};

class Memory {
 public:
  Memory(const DeviceFunctions& functions, VkDevice device, const VkPhysicalDeviceMemoryProperties& types,
         VkDeviceSize largest_range);
  ~Memory();
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  struct Block;
  class Range final : public GpuBuffer {
   public:
    Range(Block& block, VkDeviceSize offset, VkDeviceSize room, std::size_t bytes)
        : block_(block), offset_(offset), room_(room), bytes_(bytes) {}
    ~Range() override;
    std::size_t bytes() const override { return bytes_; }
    VkBuffer handle() const;
    VkDeviceSize offset() const { return offset_; }
    std::byte* mapped() const;  // of staging memory

   private:
    Block& block_;
    VkDeviceSize offset_, room_;
    std::size_t bytes_;
  };

  // NoSpace where the device has no room; Unsupported for more than it lets a kernel see at once.
  Result<std::unique_ptr<Range>> take(std::size_t bytes, MemoryUse use);

 private:
  Result<Block*> add_block(VkDeviceSize bytes, MemoryUse use);
  int type_for(std::uint32_t allowed, MemoryUse use) const;

  const DeviceFunctions& vk_;
  VkDevice device_;
  VkPhysicalDeviceMemoryProperties types_;
  VkDeviceSize largest_range_;
  std::vector<std::unique_ptr<Block>> blocks_;
};

}  // namespace hdrcam::vulkan
