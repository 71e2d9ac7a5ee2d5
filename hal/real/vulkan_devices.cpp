#include "hal/real/vulkan_devices.h"

#ifdef HDRCAM_HAVE_VULKAN
#define VK_NO_PROTOTYPES
#include <dlfcn.h>
#include <vulkan/vulkan_core.h>

#include <utility>
#endif

namespace hdrcam {

#ifdef HDRCAM_HAVE_VULKAN
namespace {

const char* kind_of(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "software";
    default:
      return "other";
  }
}

// An instance, and the functions that come from it.
class Instance {
 public:
  static Result<Instance> create(PFN_vkGetInstanceProcAddr get) {
    const auto make = reinterpret_cast<PFN_vkCreateInstance>(get(nullptr, "vkCreateInstance"));
    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "hdrcam";
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pApplicationInfo = &application;
    VkInstance instance = VK_NULL_HANDLE;
    if (make == nullptr || make(&info, nullptr, &instance) != VK_SUCCESS)
      return Error{ErrorCode::NotFound,
                   "Vulkan has no driver here; install mesa-vulkan-drivers or the maker's"};
    return Instance(get, instance);
  }
  Instance(Instance&& other) noexcept
      : get_(other.get_), instance_(std::exchange(other.instance_, nullptr)) {}
  Instance& operator=(Instance&&) = delete;
  ~Instance() {
    if (instance_ != VK_NULL_HANDLE) function<PFN_vkDestroyInstance>("vkDestroyInstance")(instance_, nullptr);
  }

  std::vector<VulkanDevice> devices() const {
    const auto enumerate = function<PFN_vkEnumeratePhysicalDevices>("vkEnumeratePhysicalDevices");
    std::uint32_t count = 0;
    if (enumerate(instance_, &count, nullptr) != VK_SUCCESS) return {};
    std::vector<VkPhysicalDevice> handles(count);
    const VkResult complete = enumerate(instance_, &count, handles.data());
    if (complete != VK_SUCCESS && complete != VK_INCOMPLETE) return {};
    std::vector<VulkanDevice> devices;
    for (std::uint32_t i = 0; i < count; ++i) devices.push_back(describe(handles[i]));
    return devices;
  }

 private:
  Instance(PFN_vkGetInstanceProcAddr get, VkInstance instance) : get_(get), instance_(instance) {}

  template <class Function>
  Function function(const char* name) const {
    return reinterpret_cast<Function>(get_(instance_, name));
  }
  VulkanDevice describe(VkPhysicalDevice handle) const {
    VkPhysicalDeviceProperties properties{};
    function<PFN_vkGetPhysicalDeviceProperties>("vkGetPhysicalDeviceProperties")(handle, &properties);
    VkPhysicalDeviceMemoryProperties memory{};
    function<PFN_vkGetPhysicalDeviceMemoryProperties>("vkGetPhysicalDeviceMemoryProperties")(handle, &memory);
    VulkanDevice device;
    device.name = properties.deviceName;
    device.kind = kind_of(properties.deviceType);
    device.api =
        fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(properties.apiVersion),
                    VK_API_VERSION_MINOR(properties.apiVersion), VK_API_VERSION_PATCH(properties.apiVersion));
    for (std::uint32_t i = 0; i < memory.memoryHeapCount; ++i)
      if ((memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0)
        device.memory_gib += static_cast<double>(memory.memoryHeaps[i].size) / (1 << 30);
    return device;
  }

  PFN_vkGetInstanceProcAddr get_;
  VkInstance instance_;
};

}  // namespace

Result<std::vector<VulkanDevice>> vulkan_devices() {
  // Never closed: drivers leave thread-local state on each thread that has used them.
  static void* const library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr)
    return Error{ErrorCode::NotFound, "there is no Vulkan loader; install libvulkan1 and a driver"};
  const auto get = reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library, "vkGetInstanceProcAddr"));
  if (get == nullptr)
    return Error{ErrorCode::NotFound, "libvulkan.so.1 is no Vulkan loader; install libvulkan1 anew"};
  const Instance instance = TRY(Instance::create(get));
  return instance.devices();
}
#else
Result<std::vector<VulkanDevice>> vulkan_devices() {
  return Error{ErrorCode::Unsupported,
               "this hdrcam was built without Vulkan's headers; install libvulkan-dev and build again"};
}
#endif

}  // namespace hdrcam
