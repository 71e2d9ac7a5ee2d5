#ifdef HDRCAM_HAVE_VULKAN
#include "hal/gpu/vulkan/work.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "hal/core/worker_pool.h"

namespace hdrcam::vulkan {
namespace {

constexpr std::uint32_t kSetsPerPool = 256, kBuffersPerPool = 2048;
constexpr std::uint64_t kPatience_ns = 20'000'000'000;  // a step of ours takes milliseconds
constexpr VkPipelineStageFlags kWorkStages =
    VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
constexpr std::size_t kCarried = 256 << 10;  // bytes that a thread takes at a time
constexpr std::uint32_t kMostTimed = 1024;

const Memory::Range& range_of(const GpuBuffer& buffer) { return static_cast<const Memory::Range&>(buffer); }

std::uint32_t groups(int elements, int group) {
  return static_cast<std::uint32_t>((elements + group - 1) / group);
}

}  // namespace

Kernel::~Kernel() {
  if (pipeline != VK_NULL_HANDLE) vk.DestroyPipeline(device, pipeline, nullptr);
  if (layout != VK_NULL_HANDLE) vk.DestroyPipelineLayout(device, layout, nullptr);
  if (set_layout != VK_NULL_HANDLE) vk.DestroyDescriptorSetLayout(device, set_layout, nullptr);
  if (module != VK_NULL_HANDLE) vk.DestroyShaderModule(device, module, nullptr);
}

Work::~Work() {
  if (ticks_ != VK_NULL_HANDLE) vk_.DestroyQueryPool(device_, ticks_, nullptr);
  if (fence_ != VK_NULL_HANDLE) vk_.DestroyFence(device_, fence_, nullptr);
  for (VkDescriptorPool pool : descriptors_) vk_.DestroyDescriptorPool(device_, pool, nullptr);
  if (command_pool_ != VK_NULL_HANDLE) vk_.DestroyCommandPool(device_, command_pool_, nullptr);
}

Result<void> Work::open(std::uint32_t queue_family) {
  constexpr const char* kDoing = "making a command buffer";
  VkCommandPoolCreateInfo pool{};
  pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = queue_family;
  if (const VkResult r = vk_.CreateCommandPool(device_, &pool, nullptr, &command_pool_); r != VK_SUCCESS)
    return failed(r, kDoing);
  VkCommandBufferAllocateInfo commands{};
  commands.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  commands.commandPool = command_pool_;
  commands.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  commands.commandBufferCount = 1;
  if (const VkResult r = vk_.AllocateCommandBuffers(device_, &commands, &commands_); r != VK_SUCCESS)
    return failed(r, kDoing);
  VkFenceCreateInfo fence{};
  fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
  if (const VkResult r = vk_.CreateFence(device_, &fence, nullptr, &fence_); r != VK_SUCCESS)
    return failed(r, kDoing);
  return {};
}

void Work::carry(std::span<const std::byte> from, std::byte* to) const {
  if (pool_ == nullptr || from.size() <= kCarried) {
    std::memcpy(to, from.data(), from.size());
    return;
  }
  pool_->for_each(static_cast<int>((from.size() + kCarried - 1) / kCarried), [&](int i) {
    const std::size_t at = static_cast<std::size_t>(i) * kCarried;
    std::memcpy(to + at, from.data() + at, std::min(kCarried, from.size() - at));
  });
}

bool Work::begin() {
  if (!error_) return false;
  if (lost_) {
    error_ = Error{ErrorCode::Unplugged, "the graphics device was lost before"};
    return false;
  }
  if (recording_) return true;
  VkCommandBufferBeginInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  if (const VkResult r = vk_.BeginCommandBuffer(commands_, &info); r != VK_SUCCESS) {
    error_ = failed(r, "beginning work");
    return false;
  }
  recording_ = true;
  if (times_ != nullptr) vk_.CmdResetQueryPool(commands_, ticks_, 0, 2 * kMostTimed);
  return true;
}

void Work::barrier(VkPipelineStageFlags from, VkPipelineStageFlags to, VkAccessFlags seen_by) {
  VkMemoryBarrier all{};
  all.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  all.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_READ_BIT |
                      VK_ACCESS_TRANSFER_READ_BIT;
  all.dstAccessMask = seen_by;
  vk_.CmdPipelineBarrier(commands_, from, to, 0, 1, &all, 0, nullptr, 0, nullptr);
}

// The barrier before a step lets it begin when those before it have ended: so does its first tick.
template <class Record>
void Work::timed(std::string_view step, const Record& record) {
  if (times_ == nullptr || timed_.size() == kMostTimed) {
    record();
    return;
  }
  const auto tick = static_cast<std::uint32_t>(2 * timed_.size());
  timed_.emplace_back(step);
  vk_.CmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, ticks_, tick);
  record();
  vk_.CmdWriteTimestamp(commands_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, ticks_, tick + 1);
}

void Work::upload(std::span<const std::byte> from, const GpuBuffer& to, std::size_t at) {
  HDRCAM_CHECK(at <= to.bytes() && from.size() <= to.bytes() - at);
  if (!begin()) return;
  auto staging = memory_.take(from.size(), MemoryUse::Staging);
  if (!staging) {
    error_ = staging.error();
    return;
  }
  carry(from, (*staging)->mapped());
  copy("upload", {**staging}, {range_of(to), at}, from.size());
  staged_.push_back(std::move(*staging));
}

void Work::copy(const GpuBuffer& from, const GpuBuffer& to) {
  if (begin()) copy("copy", {range_of(from)}, {range_of(to)}, std::min(from.bytes(), to.bytes()));
}

void Work::copy(const char* step, const Place& from, const Place& to, std::size_t bytes) {
  barrier(kWorkStages, VK_PIPELINE_STAGE_TRANSFER_BIT,
          VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT);
  const VkBufferCopy region{from.range.offset() + from.at, to.range.offset() + to.at, bytes};
  timed(step, [&] { vk_.CmdCopyBuffer(commands_, from.range.handle(), to.range.handle(), 1, &region); });
}

void Work::clear(const GpuBuffer& buffer) {
  if (!begin()) return;
  const Memory::Range& range = range_of(buffer);
  barrier(kWorkStages, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT);
  timed("clear", [&] { vk_.CmdFillBuffer(commands_, range.handle(), range.offset(), buffer.bytes(), 0); });
}

void Work::run(const GpuKernel& kernel, std::span<const GpuBuffer* const> buffers,
               std::span<const std::byte> constants, const GpuGrid& grid) {
  const auto& own = static_cast<const Kernel&>(kernel);
  HDRCAM_CHECK_EQ(static_cast<int>(buffers.size()), own.buffers);
  HDRCAM_CHECK(constants.size() <= kConstantBytes && grid.columns > 0 && grid.rows > 0 && grid.planes > 0);
  if (!begin()) return;
  auto set = set_for(own);
  if (!set) {
    error_ = set.error();
    return;
  }
  std::array<VkDescriptorBufferInfo, kMostKernelBuffers> places;
  std::array<VkWriteDescriptorSet, kMostKernelBuffers> writes;
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const Memory::Range& range = range_of(*buffers[i]);
    places[i] = {range.handle(), range.offset(), range.bytes()};
    writes[i] = {};
    writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    writes[i].dstSet = *set;
    writes[i].dstBinding = static_cast<std::uint32_t>(i);
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = own.type_of(static_cast<int>(i));
    writes[i].pBufferInfo = &places[i];
  }
  vk_.UpdateDescriptorSets(device_, static_cast<std::uint32_t>(buffers.size()), writes.data(), 0, nullptr);
  vk_.CmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, own.pipeline);
  vk_.CmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, own.layout, 0, 1, &*set, 0, nullptr);
  if (!constants.empty())
    vk_.CmdPushConstants(commands_, own.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                         static_cast<std::uint32_t>(constants.size()), constants.data());
  barrier(kWorkStages, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
          VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_UNIFORM_READ_BIT);
  timed(own.name, [&] {
    vk_.CmdDispatch(commands_, groups(grid.columns, own.group), static_cast<std::uint32_t>(grid.rows),
                    static_cast<std::uint32_t>(grid.planes));
  });
}

void Work::download(const GpuBuffer& from, std::size_t at, std::span<std::byte> to) {
  HDRCAM_CHECK(at <= from.bytes() && to.size() <= from.bytes() - at);
  if (!begin()) return;
  auto staging = memory_.take(to.size(), MemoryUse::Staging);
  if (!staging) {
    error_ = staging.error();
    return;
  }
  copy("download", {range_of(from), at}, {**staging}, to.size());
  arrivals_.push_back({std::move(*staging), to});
}

void Work::measure(GpuStepTimes* times) {
  HDRCAM_CHECK(!recording_);
  times_ = nullptr;
  if (times == nullptr || !clock_.ticks()) return;
  VkQueryPoolCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = 2 * kMostTimed;
  if (ticks_ == VK_NULL_HANDLE && vk_.CreateQueryPool(device_, &info, nullptr, &ticks_) != VK_SUCCESS) return;
  times_ = times;
}

void Work::take_times() {
  const std::size_t steps = timed_.size();
  std::vector<std::uint64_t> ticks(2 * steps);
  if (steps == 0 || vk_.GetQueryPoolResults(device_, ticks_, 0, static_cast<std::uint32_t>(ticks.size()),
                                            ticks.size() * sizeof ticks[0], ticks.data(), sizeof ticks[0],
                                            VK_QUERY_RESULT_64_BIT) != VK_SUCCESS)
    return;
  for (std::size_t i = 0; i < steps; ++i) {
    GpuStepTime& step = (*times_)[timed_[i]];
    step.ms += clock_.ms_between(ticks[2 * i], ticks[2 * i + 1]);
    ++step.times;
  }
}

Result<VkDescriptorSet> Work::set_for(const Kernel& kernel) {
  VkDescriptorSetAllocateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
  info.descriptorSetCount = 1;
  info.pSetLayouts = &kernel.set_layout;
  for (; descriptors_used_ < descriptors_.size(); ++descriptors_used_) {
    info.descriptorPool = descriptors_[descriptors_used_];
    VkDescriptorSet set = VK_NULL_HANDLE;
    if (vk_.AllocateDescriptorSets(device_, &info, &set) == VK_SUCCESS) return set;
  }
  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, kBuffersPerPool},
                                        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, kSetsPerPool}};
  VkDescriptorPoolCreateInfo pool{};
  pool.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
  pool.maxSets = kSetsPerPool;
  pool.poolSizeCount = 2, pool.pPoolSizes = sizes;
  VkDescriptorSet set = VK_NULL_HANDLE;
  VkResult made = vk_.CreateDescriptorPool(device_, &pool, nullptr, &info.descriptorPool);
  if (made == VK_SUCCESS) {
    descriptors_.push_back(info.descriptorPool);
    made = vk_.AllocateDescriptorSets(device_, &info, &set);
  }
  if (made != VK_SUCCESS) return failed(made, fmt::format("binding the buffers of '{}'", kernel.name));
  return set;
}

Result<void> Work::submit() {
  barrier(kWorkStages, VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
  if (const VkResult r = vk_.EndCommandBuffer(commands_); r != VK_SUCCESS) return failed(r, "ending work");
  VkSubmitInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  info.commandBufferCount = 1, info.pCommandBuffers = &commands_;
  if (const VkResult r = vk_.QueueSubmit(queue_, 1, &info, fence_); r != VK_SUCCESS)
    return failed(r, "handing work over");
  if (const VkResult r = vk_.WaitForFences(device_, 1, &fence_, VK_TRUE, kPatience_ns); r != VK_SUCCESS) {
    answers_ = r == VK_ERROR_DEVICE_LOST;
    return failed(r, "waiting for work");
  }
  if (const VkResult r = vk_.ResetFences(device_, 1, &fence_); r != VK_SUCCESS) {
    lost_ = true;  // the fence stays set: further work would not be waited for
    return failed(r, "waiting for work");
  }
  return {};
}

Result<void> Work::finish() {
  Result<void> done = error_;
  if (recording_) {
    if (done)
      done = submit();
    else
      (void)vk_.EndCommandBuffer(commands_);
  }
  lost_ = lost_ || !answers_ || (!done && done.error().code == ErrorCode::Unplugged);
  if (done)
    for (const Arrival& arrival : arrivals_)
      carry({arrival.staging->mapped(), arrival.to.size()}, arrival.to.data());
  if (done && times_ != nullptr) take_times();
  timed_.clear();
  // what an unanswering device may still read is not given to others: nothing is taken any more
  staged_.clear(), arrivals_.clear();
  if (!lost_)
    for (VkDescriptorPool pool : descriptors_) (void)vk_.ResetDescriptorPool(device_, pool, 0);
  descriptors_used_ = 0;
  recording_ = false;
  error_ = {};
  return done;
}

}  // namespace hdrcam::vulkan
#endif
