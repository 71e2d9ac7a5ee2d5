// One command buffer, recorded and submitted again and again. Between two steps stands a barrier for all
// memory: steps are few and long, and what depends on what need not be told. Thread-bound.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/gpu/vulkan/memory.h"

namespace hdrcam::vulkan {

// A compiled shader and its layout; the device outlives it.
struct Kernel final : GpuKernel {
  const DeviceFunctions& vk;
  VkDevice device;
  std::string name;
  int buffers = 0;
  int group = 1;               // invocations of a work group
  std::uint32_t uniforms = 0;  // a bit for each binding that is a uniform buffer, not a storage buffer
  VkShaderModule module = VK_NULL_HANDLE;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;

  Kernel(const DeviceFunctions& functions, VkDevice of_device) : vk(functions), device(of_device) {}
  ~Kernel() override;
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;

  VkDescriptorType type_of(int binding) const {
    return (uniforms >> binding & 1) != 0 ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER
                                          : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  }
};

constexpr std::uint32_t kConstantBytes = 128;  // what every device offers

// What counts the ticks of a queue (VkQueueFamilyProperties::timestampValidBits).
struct QueueClock {
  double tick_ns = 0;
  std::uint32_t bits = 0;  // of a count; 0: there is no clock. Those above are undefined.

  bool ticks() const { return tick_ns > 0 && bits > 0; }
  // A count begins anew at 0: one of 36 bits and 1 ns every 69 s.
  double ms_between(std::uint64_t first, std::uint64_t last) const {
    const std::uint64_t valid = bits < 64 ? (std::uint64_t{1} << bits) - 1 : ~std::uint64_t{0};
    return static_cast<double>((last - first) & valid) * tick_ns * 1e-6;
  }
};

class Work final : public GpuWork {
 public:
  Work(const DeviceFunctions& functions, VkDevice device, VkQueue queue, Memory& memory,
       const QueueClock& clock)
      : vk_(functions), device_(device), queue_(queue), memory_(memory), clock_(clock) {}
  ~Work() override;

  Result<void> open(std::uint32_t queue_family);

  using GpuWork::download, GpuWork::run, GpuWork::upload;
  void upload(std::span<const std::byte> from, const GpuBuffer& to, std::size_t at) override;
  void copy(const GpuBuffer& from, const GpuBuffer& to) override;
  void clear(const GpuBuffer& buffer) override;
  void run(const GpuKernel& kernel, std::span<const GpuBuffer* const> buffers,
           std::span<const std::byte> constants, const GpuGrid& grid) override;
  void download(const GpuBuffer& from, std::size_t at, std::span<std::byte> to) override;
  Result<void> finish() override;
  void measure(GpuStepTimes* times) override;
  void carry_with(WorkerPool* pool) override { pool_ = pool; }
  // Not where it was given up, after a time or because waiting failed: it may still be at work.
  bool answers() const { return answers_; }

 private:
  struct Arrival {
    std::unique_ptr<Memory::Range> staging;
    std::span<std::byte> to;
  };

  void carry(std::span<const std::byte> from, std::byte* to) const;
  bool begin();  // false: something has failed already
  void barrier(VkPipelineStageFlags from, VkPipelineStageFlags to, VkAccessFlags seen_by);
  struct Place {
    const Memory::Range& range;
    std::size_t at = 0;  // bytes from its start
  };
  void copy(const char* step, const Place& from, const Place& to, std::size_t bytes);
  template <class Record>
  void timed(std::string_view step, const Record& record);
  void take_times();
  Result<VkDescriptorSet> set_for(const Kernel& kernel);
  Result<void> submit();

  const DeviceFunctions& vk_;
  VkDevice device_;
  VkQueue queue_;
  Memory& memory_;
  const QueueClock clock_;
  VkCommandPool command_pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  std::vector<VkDescriptorPool> descriptors_;
  std::size_t descriptors_used_ = 0;  // the pool that sets are taken from
  bool recording_ = false, lost_ = false, answers_ = true;
  Result<void> error_;
  std::vector<std::unique_ptr<Memory::Range>> staged_;
  std::vector<Arrival> arrivals_;
  WorkerPool* pool_ = nullptr;
  GpuStepTimes* times_ = nullptr;  // null: nothing is measured
  VkQueryPool ticks_ = VK_NULL_HANDLE;
  std::vector<std::string> timed_;  // the steps with two ticks each
};

}  // namespace hdrcam::vulkan
