// The buffers of one libcamera stream, mapped. Thread-compatible.
#pragma once

#include <libcamera/camera.h>
#include <libcamera/framebuffer_allocator.h>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "hal/core/result.h"

namespace hdrcam {

class LibcameraBuffers {
 public:
  // Allocates as many as the pipeline provides, at most `wanted`.
  static Result<std::unique_ptr<LibcameraBuffers>> allocate(const std::shared_ptr<libcamera::Camera>& camera,
                                                            libcamera::Stream& stream, int wanted);
  ~LibcameraBuffers();
  LibcameraBuffers(const LibcameraBuffers&) = delete;
  LibcameraBuffers& operator=(const LibcameraBuffers&) = delete;

  std::size_t size() const { return mapped_.size(); }
  libcamera::FrameBuffer& buffer(std::size_t index) const { return *mapped_[index].buffer; }
  // All planes, one after the other.
  std::span<const std::byte> memory(std::size_t index) const { return mapped_[index].planes; }

 private:
  explicit LibcameraBuffers(std::shared_ptr<libcamera::Camera> camera, libcamera::Stream& stream);
  Result<void> map(libcamera::FrameBuffer& buffer);

  struct Mapped {
    libcamera::FrameBuffer* buffer = nullptr;
    void* memory = nullptr;
    std::size_t length = 0;
    std::span<const std::byte> planes;
  };
  libcamera::FrameBufferAllocator allocator_;
  libcamera::Stream& stream_;
  std::vector<Mapped> mapped_;
};

}  // namespace hdrcam
