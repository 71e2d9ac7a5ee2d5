// One command buffer, recorded and submitted again and again. Between two steps stands a barrier for all
// memory: steps are few and long, and what depends on what need not be told. Thread-bound.
#pragma once

#include <map>
#include <vector>

#include "hal/gpu/vulkan/memory.h"

namespace hdrcam::vulkan {

struct Kernel final : GpuKernel {
  std::string name;
  int buffers = 0;
  std::uint32_t uniforms = 0;  // a bit for each binding that is a uniform buffer, not a storage buffer
  VkShaderModule module = VK_NULL_HANDLE;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
};

constexpr std::uint32_t kConstantBytes = 128;  // what every device offers

class Work final : public GpuWork {
 public:
  Work(const DeviceFunctions& functions, VkDevice device, VkQueue queue, Memory& memory, int group)
      : vk_(functions), device_(device), queue_(queue), memory_(memory), group_(group) {}
  ~Work() override;

  Result<void> open(std::uint32_t queue_family);

  using GpuWork::run;
  void upload(std::span<const std::byte> from, const GpuBuffer& to) override;
  void copy(const GpuBuffer& from, const GpuBuffer& to) override;
  void clear(const GpuBuffer& buffer) override;
  void run(const GpuKernel& kernel, std::span<const GpuBuffer* const> buffers,
           std::span<const std::byte> constants, const GpuGrid& grid) override;
  void download(const GpuBuffer& from, std::span<std::byte> to) override;
  Result<void> finish() override;

 private:
  struct Arrival {
    std::unique_ptr<Memory::Range> staging;
    std::span<std::byte> to;
  };

  bool begin();  // false: something has failed already
  void barrier(VkPipelineStageFlags from, VkPipelineStageFlags to, VkAccessFlags seen_by);
  Result<VkDescriptorSet> set_for(const Kernel& kernel);
  Result<void> submit();

  const DeviceFunctions& vk_;
  VkDevice device_;
  VkQueue queue_;
  Memory& memory_;
  int group_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  std::vector<VkDescriptorPool> descriptors_;
  std::size_t descriptors_used_ = 0;  // the pool that sets are taken from
  bool recording_ = false, lost_ = false;
  Result<void> error_;
  std::vector<std::unique_ptr<Memory::Range>> staged_;
  std::vector<Arrival> arrivals_;
};

}  // namespace hdrcam::vulkan
