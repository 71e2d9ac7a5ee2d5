// The graphics devices that Vulkan knows, software ones included, and what keeps one from being used. The
// loader is opened when asked for, so that neither build nor program depends on it. Reentrant.
#pragma once

#include <vector>

#include "hal/gpu/gpu_device.h"

namespace hdrcam {

// In the order in which open_gpu() takes them. NotFound where no loader or no driver is installed,
// Unsupported in a build without Vulkan: each says what to install.
Result<std::vector<GpuFacts>> list_gpus();

}  // namespace hdrcam
