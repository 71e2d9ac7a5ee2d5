#ifdef HDRCAM_HAVE_LIBCAMERA
#include "hal/real/libcamera_buffers.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace hdrcam {

LibcameraBuffers::LibcameraBuffers(std::shared_ptr<libcamera::Camera> camera, libcamera::Stream& stream)
    : allocator_(std::move(camera)), stream_(stream) {}

LibcameraBuffers::~LibcameraBuffers() {
  for (const Mapped& mapped : mapped_) ::munmap(mapped.memory, mapped.length);
  (void)allocator_.free(&stream_);
}

Result<std::unique_ptr<LibcameraBuffers>> LibcameraBuffers::allocate(
    const std::shared_ptr<libcamera::Camera>& camera, libcamera::Stream& stream, int wanted) {
  std::unique_ptr<LibcameraBuffers> buffers(new LibcameraBuffers(camera, stream));
  if (const int code = buffers->allocator_.allocate(&stream); code < 0)
    return Error{
        ErrorCode::Io,
        fmt::format("camera '{}' has no memory for its buffers: {}", camera->id(), std::strerror(-code)),
        -code};
  const auto& all = buffers->allocator_.buffers(&stream);
  for (std::size_t i = 0; i < std::min(all.size(), static_cast<std::size_t>(wanted)); ++i)
    TRY(buffers->map(*all[i]));
  return buffers;
}

// In all known pipelines the planes of one picture lie in one piece of memory, one after the other.
Result<void> LibcameraBuffers::map(libcamera::FrameBuffer& buffer) {
  const auto& planes = buffer.planes();
  std::size_t begin = planes[0].offset, end = begin;
  for (const auto& plane : planes) {
    if (plane.fd.get() != planes[0].fd.get())
      return Error{ErrorCode::Unsupported,
                   "the planes of a picture lie in different buffers; ask for another format"};
    begin = std::min<std::size_t>(begin, plane.offset),
    end = std::max<std::size_t>(end, plane.offset + plane.length);
  }
  void* memory = ::mmap(nullptr, end, PROT_READ, MAP_SHARED, planes[0].fd.get(), 0);
  if (memory == MAP_FAILED)
    return Error{ErrorCode::Io, fmt::format("a camera buffer cannot be mapped: {}", std::strerror(errno)),
                 errno};
  mapped_.push_back({&buffer, memory, end, {static_cast<const std::byte*>(memory) + begin, end - begin}});
  return {};
}

}  // namespace hdrcam
#endif
