#ifdef HDRCAM_HAVE_VULKAN
#include "hal/gpu/vulkan/device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "hal/gpu/vulkan/pipeline_cache.h"

namespace hdrcam::vulkan {
namespace {

constexpr int kLeastGroup = 64;

// Whole subgroups, and enough of them to hide the memory behind.
int group_size(const PhysicalDevice& device) {
  const VkPhysicalDeviceLimits& limits = device.properties.limits;
  const auto most =
      static_cast<int>(std::min(limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0]));
  const int subgroup = std::max(1, device.facts.subgroup);
  return std::min(most, (kLeastGroup + subgroup - 1) / subgroup * subgroup);
}

// A bit for each binding whose variable lies in uniform memory, as the shader's own words say (SPIR-V:
// OpVariable with its storage class, OpDecorate with its binding).
std::uint32_t uniform_bindings(std::span<const std::uint32_t> code) {
  constexpr std::uint32_t kDecorate = 71, kVariable = 59, kBinding = 33, kUniform = 2, kHeader = 5;
  std::map<std::uint32_t, std::uint32_t> binding_of;
  std::uint32_t uniforms = 0;
  for (std::size_t at = kHeader; at < code.size() && code[at] >> 16 != 0; at += code[at] >> 16) {
    const std::uint32_t operation = code[at] & 0xffff;
    if (operation == kDecorate && code[at + 2] == kBinding) binding_of[code[at + 1]] = code[at + 3];
    if (operation != kVariable || code[at + 3] != kUniform) continue;
    if (const auto found = binding_of.find(code[at + 2]); found != binding_of.end())
      uniforms |= 1u << found->second;
  }
  return uniforms;
}

}  // namespace

Result<std::unique_ptr<Device>> Device::open(std::unique_ptr<Instance> instance, const PhysicalDevice& which,
                                             const std::string& cache_folder) {
  std::unique_ptr<Device> device(new Device(std::move(instance), which));
  TRY(device->start(which, cache_folder));
  return device;
}

Result<void> Device::start(const PhysicalDevice& which, const std::string& cache_folder) {
  const float priority = 1;
  VkDeviceQueueCreateInfo queue_info{};
  queue_info.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue_info.queueFamilyIndex = which.queue_family;
  queue_info.queueCount = 1, queue_info.pQueuePriorities = &priority;
  VkDeviceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  info.queueCreateInfoCount = 1, info.pQueueCreateInfos = &queue_info;
  const InstanceFunctions& vki = instance_->functions();
  if (const VkResult r = vki.CreateDevice(which.handle, &info, nullptr, &device_); r != VK_SUCCESS)
    return failed(r, fmt::format("opening the graphics device '{}'", facts_.name));
  vk_ = device_functions(vki.GetDeviceProcAddr, device_);
  VkQueue queue = VK_NULL_HANDLE;
  vk_.GetDeviceQueue(device_, which.queue_family, 0, &queue);
  facts_.group = group_size(which);
  memory_ = std::make_unique<Memory>(vk_, device_, which.memory, limits_.maxStorageBufferRange);
  const QueueClock clock{static_cast<double>(limits_.timestampPeriod), which.tick_bits};
  work_ = std::make_unique<Work>(vk_, device_, queue, *memory_, clock);
  TRY(work_->open(which.queue_family));
  cache_path_ = pipeline_cache_path(cache_folder, which.uuid);
  open_cache();
  return {};
}

// A device that does not answer may use all that it was given until the program ends, and so long it is
// there: to wait for it would never end either.
void Device::forsake() {
  struct Forsaken {
    std::unique_ptr<Instance> instance;
    std::unique_ptr<Memory> memory;
    std::unique_ptr<Work> work;
    Kernels kernels;
  };
  static auto* const forsaken = new std::vector<Forsaken>;
  forsaken->push_back({std::move(instance_), std::move(memory_), std::move(work_), std::move(kernels_)});
}

Device::~Device() {
  if (device_ == VK_NULL_HANDLE) return;
  if (work_ != nullptr && !work_->answers()) {
    forsake();
    return;
  }
  (void)vk_.DeviceWaitIdle(device_);
  keep_cache();
  kernels_.clear();
  if (cache_ != VK_NULL_HANDLE) vk_.DestroyPipelineCache(device_, cache_, nullptr);
  work_.reset();
  memory_.reset();
  vk_.DestroyDevice(device_, nullptr);
}

// Without a cache kernels are compiled anew: slower, no error.
void Device::open_cache() {
  const std::vector<std::byte> known = read_pipeline_cache(posix_storage(), cache_path_);
  VkPipelineCacheCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
  info.initialDataSize = known.size(), info.pInitialData = known.data();
  cached_bytes_ = known.size();
  if (vk_.CreatePipelineCache(device_, &info, nullptr, &cache_) != VK_SUCCESS) cache_ = VK_NULL_HANDLE;
}

void Device::keep_cache() {
  if (cache_ == VK_NULL_HANDLE || cache_path_.empty()) return;
  std::size_t bytes = 0;
  if (vk_.GetPipelineCacheData(device_, cache_, &bytes, nullptr) != VK_SUCCESS || bytes == cached_bytes_)
    return;
  std::vector<std::byte> compiled(bytes);
  if (vk_.GetPipelineCacheData(device_, cache_, &bytes, compiled.data()) != VK_SUCCESS) return;
  compiled.resize(bytes);
  (void)write_pipeline_cache(posix_storage(), cache_path_, compiled);  // it only saves time
}

Result<std::unique_ptr<GpuBuffer>> Device::buffer(std::size_t bytes) {
  return std::unique_ptr<GpuBuffer>(TRY(memory_->take(bytes, MemoryUse::Compute)));
}

Result<const GpuKernel*> Device::kernel(const GpuShader& shader) {
  if (const auto kept = kernels_.find(shader.name); kept != kernels_.end()) return kept->second.get();
  HDRCAM_CHECK(shader.buffers <= kMostKernelBuffers);
  auto kernel = std::make_unique<Kernel>(vk_, device_);
  kernel->name = shader.name, kernel->buffers = shader.buffers;
  kernel->group = shader.group > 0 ? shader.group : facts_.group;
  kernel->uniforms = uniform_bindings(shader.code);
  TRY(compile(shader, *kernel));
  return kernels_.emplace(shader.name, std::move(kernel)).first->second.get();
}

Result<void> Device::compile(const GpuShader& shader, Kernel& kernel) {
  const std::string doing = fmt::format("compiling the kernel '{}'", shader.name);
  VkShaderModuleCreateInfo module{};
  module.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  module.codeSize = shader.code.size_bytes(), module.pCode = shader.code.data();
  VkResult done = vk_.CreateShaderModule(device_, &module, nullptr, &kernel.module);

  std::vector<VkDescriptorSetLayoutBinding> bindings;
  bindings.reserve(static_cast<std::size_t>(shader.buffers));
  for (int i = 0; i < shader.buffers; ++i)
    bindings.push_back(
        {static_cast<std::uint32_t>(i), kernel.type_of(i), 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
  VkDescriptorSetLayoutCreateInfo set{};
  set.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  set.bindingCount = static_cast<std::uint32_t>(bindings.size()), set.pBindings = bindings.data();
  if (done == VK_SUCCESS) done = vk_.CreateDescriptorSetLayout(device_, &set, nullptr, &kernel.set_layout);

  const VkPushConstantRange constants{VK_SHADER_STAGE_COMPUTE_BIT, 0, kConstantBytes};
  VkPipelineLayoutCreateInfo layout{};
  layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  layout.setLayoutCount = 1, layout.pSetLayouts = &kernel.set_layout;
  layout.pushConstantRangeCount = 1, layout.pPushConstantRanges = &constants;
  if (done == VK_SUCCESS) done = vk_.CreatePipelineLayout(device_, &layout, nullptr, &kernel.layout);

  const auto group = static_cast<std::uint32_t>(facts_.group);
  const VkSpecializationMapEntry entry{0, 0, sizeof group};
  const VkSpecializationInfo special{1, &entry, sizeof group, &group};
  VkComputePipelineCreateInfo pipeline{};
  pipeline.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  pipeline.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  pipeline.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  pipeline.stage.module = kernel.module, pipeline.stage.pName = "main";
  pipeline.stage.pSpecializationInfo = &special;
  pipeline.layout = kernel.layout;
  if (done == VK_SUCCESS)
    done = vk_.CreateComputePipelines(device_, cache_, 1, &pipeline, nullptr, &kernel.pipeline);
  if (done != VK_SUCCESS) return failed(done, doing);
  return {};
}

}  // namespace hdrcam::vulkan
#endif
