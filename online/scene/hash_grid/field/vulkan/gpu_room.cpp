#include "online/scene/hash_grid/field/vulkan/gpu_room.h"

namespace hdrcam {

Result<void> GpuRoom::reserve(GpuDevice& device, std::size_t bytes) {
  if (buffer != nullptr && buffer->bytes() >= bytes) return {};
  buffer.reset();
  buffer = TRY(device.buffer(bytes));
  return {};
}

}  // namespace hdrcam
