#include "hal/gpu/gpu_device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "hal/gpu/gpu_list.h"
#ifdef HDRCAM_HAVE_VULKAN
#include "hal/gpu/vulkan/device.h"
#endif

namespace hdrcam {
#ifdef HDRCAM_HAVE_VULKAN
namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

Result<std::unique_ptr<GpuDevice>> open_gpu(const GpuOptions& options) {
  std::unique_ptr<vulkan::Instance> instance = TRY(vulkan::Instance::open(options.complaints));
  const std::vector<vulkan::PhysicalDevice> devices = instance->devices();
  std::vector<std::string> names;
  for (const vulkan::PhysicalDevice& device : devices) {
    names.push_back(device.facts.name);
    if (lower(device.facts.name).find(lower(options.name)) == std::string::npos) continue;
    if (device.facts.missing.empty())
      return std::unique_ptr<GpuDevice>(
          TRY(vulkan::Device::open(std::move(instance), device, options.cache_folder)));
    if (!options.name.empty())
      return Error{ErrorCode::Unsupported, fmt::format("the graphics device '{}' cannot be used: {}",
                                                       device.facts.name, device.facts.missing)};
  }
  if (names.empty())
    return Error{ErrorCode::NotFound,
                 "Vulkan knows no graphics device; install mesa-vulkan-drivers or the maker's"};
  return Error{ErrorCode::NotFound,
               fmt::format("there is no graphics device '{}' that can be used; there are: {}", options.name,
                           fmt::join(names, ", "))};
}

Result<std::vector<GpuFacts>> list_gpus() {
  const std::unique_ptr<vulkan::Instance> instance = TRY(vulkan::Instance::open(nullptr));
  std::vector<GpuFacts> all;
  for (const vulkan::PhysicalDevice& device : instance->devices()) all.push_back(device.facts);
  return all;
}
#else
namespace {

Error without_vulkan() {
  return {ErrorCode::Unsupported,
          "this hdrcam was built without Vulkan; install libvulkan-dev and glslang-tools and build again"};
}

}  // namespace

Result<std::unique_ptr<GpuDevice>> open_gpu(const GpuOptions&) { return without_vulkan(); }
Result<std::vector<GpuFacts>> list_gpus() { return without_vulkan(); }
#endif

}  // namespace hdrcam
