// The graphics devices that Vulkan finds, software ones included. The loader is opened on demand, so that
// neither build nor program depends on it. Reentrant.
#pragma once

#include <string>
#include <vector>

#include "hal/core/result.h"

namespace hdrcam {

struct VulkanDevice {
  std::string name;       // as its driver says
  std::string kind;       // "discrete", "integrated", "virtual", "software", "other"
  std::string api;        // "1.3.239"
  double memory_gib = 0;  // of its own heaps
};

// NotFound where no loader or no driver is installed, Unsupported in a build without Vulkan's headers: the
// message names the package to install.
Result<std::vector<VulkanDevice>> vulkan_devices();

}  // namespace hdrcam
