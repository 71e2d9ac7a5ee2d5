#include "online/state/cpu_state.h"
#include "online/state/vulkan/vulkan_state.h"

namespace hdrcam {

std::unique_ptr<StateLayer> make_state_layer(const StateOptions& options, int rows, int cols,
                                             WorkerPool& pool, GpuDevice* gpu) {
  if (gpu == nullptr) return std::make_unique<CpuState>(options, rows, cols, pool);
  return std::make_unique<VulkanState>(options, rows, cols, pool, *gpu);
}

}  // namespace hdrcam
