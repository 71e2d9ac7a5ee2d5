#ifdef HDRCAM_HAVE_VULKAN
#include "hal/gpu/vulkan/instance.h"

#include <fmt/format.h>

#include <algorithm>

namespace hdrcam::vulkan {
namespace {

GpuKind kind_of(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return GpuKind::Discrete;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return GpuKind::Integrated;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return GpuKind::Virtual;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return GpuKind::Software;
    default:
      return GpuKind::Other;
  }
}

VKAPI_ATTR VkBool32 VKAPI_CALL keep_complaint(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                              VkDebugUtilsMessageTypeFlagsEXT,
                                              const VkDebugUtilsMessengerCallbackDataEXT* told, void* list) {
  static_cast<std::vector<std::string>*>(list)->emplace_back(told->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT listener(std::vector<std::string>* complaints) {
  VkDebugUtilsMessengerCreateInfoEXT info{};
  info.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
  info.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType =
      VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  info.pfnUserCallback = keep_complaint;
  info.pUserData = complaints;
  return info;
}

std::string version_of(const VkPhysicalDeviceProperties& device) {
  const std::uint32_t api = device.apiVersion;
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(api), VK_API_VERSION_MINOR(api),
                     VK_API_VERSION_PATCH(api));
}

template <class Function>
Function function(PFN_vkGetInstanceProcAddr get, VkInstance instance, const char* name) {
  return reinterpret_cast<Function>(get(instance, name));
}

}  // namespace

std::string what_is_missing(const VkPhysicalDeviceProperties& device, bool computes) {
  if (device.apiVersion < VK_API_VERSION_1_1)
    return fmt::format("its driver offers Vulkan {}, 1.1 is needed; install a newer one", version_of(device));
  if (!computes) return "it offers no queue for computing";
  const std::uint32_t buffers = std::min(device.limits.maxPerStageDescriptorStorageBuffers,
                                         device.limits.maxDescriptorSetStorageBuffers);
  if (buffers < kMostKernelBuffers)
    return fmt::format("its driver lets a kernel use {} buffers, {} are needed; install a newer one", buffers,
                       kMostKernelBuffers);
  return {};
}

Result<std::unique_ptr<Instance>> Instance::open(std::vector<std::string>* complaints) {
  const PFN_vkGetInstanceProcAddr get = TRY(loader()).get;
  const auto create = function<PFN_vkCreateInstance>(get, nullptr, "vkCreateInstance");
  VkApplicationInfo application{};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.pApplicationName = "hdrcam";
  application.apiVersion = VK_API_VERSION_1_1;
  VkInstanceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  info.pApplicationInfo = &application;

  constexpr const char* kLayer = "VK_LAYER_KHRONOS_validation";
  constexpr const char* kDebug = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  const VkValidationFeatureEnableEXT ordering = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features{};
  features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &ordering;
  VkDebugUtilsMessengerCreateInfoEXT hear = listener(complaints);
  if (complaints != nullptr) {
    info.enabledLayerCount = 1, info.ppEnabledLayerNames = &kLayer;
    info.enabledExtensionCount = 1, info.ppEnabledExtensionNames = &kDebug;
    info.pNext = &features, features.pNext = &hear;
  }
  VkInstance handle = VK_NULL_HANDLE;
  const VkResult made = create != nullptr ? create(&info, nullptr, &handle) : VK_ERROR_INCOMPATIBLE_DRIVER;
  if (made == VK_ERROR_LAYER_NOT_PRESENT)
    return Error{ErrorCode::Unsupported, "Vulkan's checks are not here; install vulkan-validationlayers"};
  if (made != VK_SUCCESS)
    return Error{ErrorCode::NotFound,
                 "Vulkan has no driver here; install mesa-vulkan-drivers or the maker's"};
  std::unique_ptr<Instance> instance(new Instance(get, handle));
  if (complaints != nullptr) {
    const auto listen =
        function<PFN_vkCreateDebugUtilsMessengerEXT>(get, handle, "vkCreateDebugUtilsMessengerEXT");
    if (listen != nullptr) listen(handle, &hear, nullptr, &instance->messenger_);
  }
  return instance;
}

Instance::~Instance() {
  if (messenger_ != VK_NULL_HANDLE)
    function<PFN_vkDestroyDebugUtilsMessengerEXT>(get_, instance_, "vkDestroyDebugUtilsMessengerEXT")(
        instance_, messenger_, nullptr);
  functions_.DestroyInstance(instance_, nullptr);
}

std::vector<PhysicalDevice> Instance::devices() const {
  std::uint32_t count = 0;
  if (functions_.EnumeratePhysicalDevices(instance_, &count, nullptr) != VK_SUCCESS) return {};
  std::vector<VkPhysicalDevice> handles(count);
  const VkResult complete = functions_.EnumeratePhysicalDevices(instance_, &count, handles.data());
  if (complete != VK_SUCCESS && complete != VK_INCOMPLETE) return {};
  std::vector<PhysicalDevice> devices;
  for (std::uint32_t i = 0; i < count; ++i) devices.push_back(describe(handles[i]));
  std::stable_sort(devices.begin(), devices.end(), [](const PhysicalDevice& a, const PhysicalDevice& b) {
    return a.facts.kind < b.facts.kind;  // the best first
  });
  return devices;
}

PhysicalDevice Instance::describe(VkPhysicalDevice handle) const {
  PhysicalDevice device;
  device.handle = handle;
  VkPhysicalDeviceIDProperties id{};
  id.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES;
  VkPhysicalDeviceSubgroupProperties subgroup{};
  subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
  subgroup.pNext = &id;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &subgroup;
  functions_.GetPhysicalDeviceProperties2(handle, &properties);
  functions_.GetPhysicalDeviceMemoryProperties(handle, &device.memory);
  device.properties = properties.properties;
  for (const std::uint8_t byte : id.driverUUID) device.uuid += fmt::format("{:02x}", byte);
  for (const std::uint8_t byte : id.deviceUUID) device.uuid += fmt::format("{:02x}", byte);

  const VkPhysicalDeviceProperties& own = device.properties;
  GpuFacts& facts = device.facts;
  facts.name = own.deviceName;
  facts.kind = kind_of(own.deviceType);
  facts.api = version_of(own);
  for (std::uint32_t i = 0; i < device.memory.memoryHeapCount; ++i)
    if ((device.memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0)
      facts.memory_gib += static_cast<double>(device.memory.memoryHeaps[i].size) / (1 << 30);
  facts.subgroup = static_cast<int>(subgroup.subgroupSize);

  std::uint32_t count = 0;
  functions_.GetPhysicalDeviceQueueFamilyProperties(handle, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  functions_.GetPhysicalDeviceQueueFamilyProperties(handle, &count, families.data());
  const auto computes = std::find_if(families.begin(), families.end(), [](const auto& family) {
    return (family.queueFlags & VK_QUEUE_COMPUTE_BIT) != 0;
  });
  device.queue_family = static_cast<std::uint32_t>(computes - families.begin());
  if (computes != families.end()) device.tick_bits = computes->timestampValidBits;
  facts.missing = what_is_missing(own, computes != families.end());
  return device;
}

}  // namespace hdrcam::vulkan
#endif
