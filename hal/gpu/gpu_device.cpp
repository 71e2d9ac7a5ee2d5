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
namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

const char* name(GpuKind kind) {
  switch (kind) {
    case GpuKind::Discrete:
      return "discrete";
    case GpuKind::Integrated:
      return "integrated";
    case GpuKind::Virtual:
      return "virtual";
    case GpuKind::Software:
      return "software";
    case GpuKind::Other:
      break;
  }
  return "other";
}

Result<std::size_t> find_gpu(std::span<const GpuFacts> all, const std::string& name) {
  const std::string wanted = lower(name);
  const auto is_whole = [&](const GpuFacts& gpu) { return lower(gpu.name) == wanted; };
  const bool any_whole = std::ranges::any_of(all, is_whole);  // then it is no part of a longer one
  const GpuFacts* unusable = nullptr;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < all.size(); ++i) {
    names.push_back(all[i].name);
    if (any_whole ? !is_whole(all[i]) : lower(all[i].name).find(wanted) == std::string::npos) continue;
    if (all[i].missing.empty()) return i;
    if (unusable == nullptr) unusable = &all[i];
  }
  if (unusable != nullptr)
    return Error{ErrorCode::Unsupported, fmt::format("the graphics device '{}' cannot be used: {}",
                                                     unusable->name, unusable->missing)};
  if (names.empty())
    return Error{ErrorCode::NotFound,
                 "Vulkan knows no graphics device; install mesa-vulkan-drivers or the maker's"};
  return Error{ErrorCode::NotFound,
               fmt::format("there is no graphics device '{}'; there are: {}", name, fmt::join(names, ", "))};
}

#ifdef HDRCAM_HAVE_VULKAN
Result<std::unique_ptr<GpuDevice>> open_gpu(const GpuOptions& options) {
  std::unique_ptr<vulkan::Instance> instance = TRY(vulkan::Instance::open(options.complaints));
  const std::vector<vulkan::PhysicalDevice> devices = instance->devices();
  std::vector<GpuFacts> all;
  for (const vulkan::PhysicalDevice& device : devices) all.push_back(device.facts);
  const std::size_t place = TRY(find_gpu(all, options.name));
  return std::unique_ptr<GpuDevice>(
      TRY(vulkan::Device::open(std::move(instance), devices[place], options.cache_folder)));
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
