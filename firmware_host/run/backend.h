// Where a run computes: on the processor, or on the graphics device that was asked for. What keeps a device
// from being used is a warning and a note, never the end of a run: the processor does the same work.
// Reentrant.
#pragma once

#include <memory>
#include <string>

#include "hal/gpu/gpu_device.h"

namespace hdrcam {

struct Backend {
  std::unique_ptr<GpuDevice> gpu;  // null: the processor
  std::string note;                // for the record: which device, or why not; "" where none was asked for
};

// asked: "cpu", "vulkan" for the best device, or "vulkan:NAME" for one with NAME in its name.
Backend open_backend(const std::string& asked);

}  // namespace hdrcam
