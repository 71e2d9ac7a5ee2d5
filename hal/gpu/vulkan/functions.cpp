#ifdef HDRCAM_HAVE_VULKAN
#include "hal/gpu/vulkan/functions.h"

#include <dlfcn.h>
#include <fmt/format.h>

namespace hdrcam::vulkan {

Result<Loader> loader() {
  static void* const library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr)
    return Error{ErrorCode::NotFound, "there is no Vulkan loader; install libvulkan1 and a driver"};
  const auto get = reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library, "vkGetInstanceProcAddr"));
  if (get == nullptr)
    return Error{ErrorCode::NotFound, "libvulkan.so.1 is not a Vulkan loader; reinstall libvulkan1"};
  return Loader{get};
}

InstanceFunctions instance_functions(PFN_vkGetInstanceProcAddr get, VkInstance instance) {
  InstanceFunctions found;
#define HDRCAM_FIND(name) found.name = reinterpret_cast<PFN_vk##name>(get(instance, "vk" #name));
  HDRCAM_INSTANCE_FUNCTIONS(HDRCAM_FIND)
#undef HDRCAM_FIND
  return found;
}

DeviceFunctions device_functions(PFN_vkGetDeviceProcAddr get, VkDevice device) {
  DeviceFunctions found;
#define HDRCAM_FIND(name) found.name = reinterpret_cast<PFN_vk##name>(get(device, "vk" #name));
  HDRCAM_DEVICE_FUNCTIONS(HDRCAM_FIND)
#undef HDRCAM_FIND
  return found;
}

Error failed(VkResult result, const std::string& doing) {
  switch (result) {
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_TOO_MANY_OBJECTS:
      return {ErrorCode::NoSpace, doing + ": graphics memory is full; use smaller pictures or free some"};
    case VK_ERROR_DEVICE_LOST:
      return {ErrorCode::Unplugged, doing + ": the graphics device was lost; see the kernel's log"};
    case VK_TIMEOUT:
      return {ErrorCode::Timeout, doing + ": the graphics device does not answer; see the kernel's log"};
    case VK_ERROR_FEATURE_NOT_PRESENT:
    case VK_ERROR_EXTENSION_NOT_PRESENT:
    case VK_ERROR_LAYER_NOT_PRESENT:
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return {ErrorCode::Unsupported, doing + ": the driver does not offer it; install a newer one"};
    default:
      return {ErrorCode::Io,
              fmt::format("{}: Vulkan error {}; see the driver's log", doing, static_cast<int>(result))};
  }
}

}  // namespace hdrcam::vulkan
#endif
