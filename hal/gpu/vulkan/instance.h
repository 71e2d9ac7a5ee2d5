// A connection to the Vulkan drivers of this machine, and the devices behind it. Move-only; thread-bound.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/gpu/gpu_device.h"
#include "hal/gpu/vulkan/functions.h"

namespace hdrcam::vulkan {

struct PhysicalDevice {
  VkPhysicalDevice handle = VK_NULL_HANDLE;
  GpuFacts facts;
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceMemoryProperties memory{};
  std::string uuid;  // of device and driver, in hexadecimal: what compiled kernels are made for
  std::uint32_t queue_family = 0;
  std::uint32_t tick_bits = 0;  // of the clock of that family's queues; 0: they have none
};

// What keeps a device from being used, in words; "" where nothing does. computes: it has a queue for that.
std::string what_is_missing(const VkPhysicalDeviceProperties& device, bool computes);

class Instance {
 public:
  // complaints: as in GpuOptions.
  static Result<std::unique_ptr<Instance>> open(std::vector<std::string>* complaints);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  const InstanceFunctions& functions() const { return functions_; }
  // The best first: discrete, integrated, virtual, software; in the driver's order where they are alike.
  std::vector<PhysicalDevice> devices() const;

 private:
  Instance(PFN_vkGetInstanceProcAddr get, VkInstance instance)
      : get_(get), instance_(instance), functions_(instance_functions(get, instance)) {}
  PhysicalDevice describe(VkPhysicalDevice handle) const;

  PFN_vkGetInstanceProcAddr get_;
  VkInstance instance_;
  InstanceFunctions functions_;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
};

}  // namespace hdrcam::vulkan
