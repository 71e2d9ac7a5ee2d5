#include "online/priors/motion/cpu_flow.h"
#include "online/priors/motion/vulkan/vulkan_flow.h"

namespace hdrcam {

std::unique_ptr<DenseFlow> make_dense_flow(int rows, int cols, WorkerPool& pool, GpuDevice* gpu) {
  // the processor itself, under another name, is fifty times slower at work groups with barriers
  const bool is_worth_it = gpu != nullptr && gpu->facts().kind != GpuKind::Software;
  if (!is_worth_it) return std::make_unique<CpuFlow>(pool);
  return std::make_unique<VulkanFlow>(rows, cols, pool, *gpu);
}

}  // namespace hdrcam
