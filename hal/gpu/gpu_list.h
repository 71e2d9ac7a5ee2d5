// The graphics devices that Vulkan knows, software ones included, and what keeps one from being used. The
// loader is opened when asked for, so that neither build nor program depends on it. Reentrant.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hal/gpu/gpu_device.h"

namespace hdrcam {

// In the order in which open_gpu() takes them. NotFound where no loader or no driver is installed,
// Unsupported in a build without Vulkan: each says what to install.
Result<std::vector<GpuFacts>> list_gpus();

// The first of them that is called `name`, in any case, and can be used; where none is called so, that has it
// in its own. Unsupported, saying what is missing, where those that are meant cannot be used; NotFound,
// naming all, where none is meant.
Result<std::size_t> find_gpu(std::span<const GpuFacts> all, const std::string& name);

}  // namespace hdrcam
