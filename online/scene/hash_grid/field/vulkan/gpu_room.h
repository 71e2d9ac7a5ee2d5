// Memory of a graphics device that grows when more is asked of it. Thread-bound like the device, which
// outlives it.
#pragma once

#include <cstddef>
#include <memory>

#include "hal/gpu/gpu_device.h"

namespace hdrcam {

struct GpuRoom {
  std::unique_ptr<GpuBuffer> buffer;
  const GpuBuffer* operator*() const { return buffer.get(); }

  // Made anew where it is smaller: what was in it is lost. Errors: those of the device.
  Result<void> reserve(GpuDevice& device, std::size_t bytes);
};

}  // namespace hdrcam
