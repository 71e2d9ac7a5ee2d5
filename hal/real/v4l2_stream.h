// The buffers of a V4L2 capture queue: memory of the driver mapped here (MMAP) and exported where the driver
// can (DMABUF), and one media request per buffer where the driver takes controls with its frames (request
// API). Thread-compatible.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hal/camera.h"
#include "hal/descriptor.h"
#include "hal/real/device_node.h"

namespace hdrcam {

class V4l2Stream {
 public:
  // `video` outlives this. `media`: the node for media requests, or nullptr; it outlives this too.
  V4l2Stream(const DeviceNode& video, const DeviceNode* media, std::uint32_t queue_type)
      : video_(video), media_(media), queue_type_(queue_type) {}
  ~V4l2Stream();
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;

  // Replaces all buffers; not while started. A driver may provide fewer, or more, which it then needs queued.
  // Busy where another program streams.
  Result<void> allocate(int buffers);
  int buffers() const { return static_cast<int>(buffers_.size()); }
  std::span<const std::byte> memory(int index) const {
    const auto& memory = buffers_[static_cast<std::size_t>(index)].memory;
    return {memory.get(), memory.get_deleter().bytes};
  }
  int dmabuf_fd(int index) const { return buffers_[static_cast<std::size_t>(index)].dmabuf.get(); }
  // This buffer's media request; -1 where there is none. It holds the controls of its last frame until
  // renew().
  int request_fd(int index) const { return buffers_[static_cast<std::size_t>(index)].request.get(); }

  // As the driver's queue reports them, once buffers are allocated.
  bool takes_requests() const { return media_ != nullptr; }
  TimestampMark timestamp_mark() const { return timestamp_mark_; }

  Result<void> start();
  Result<void> stop();
  // Empties the buffer's media request, so that controls can be set in it.
  Result<void> renew(int index);
  Result<void> queue(int index);

  struct Filled {
    int index = 0;
    std::uint32_t sequence = 0, flags = 0;
    std::size_t begin = 0, bytes = 0;  // of the picture in the buffer's memory
    Duration stamp{0};                 // of the clock that the flags name
  };
  // The next filled buffer; nullopt where none is ready. Unplugged.
  Result<std::optional<Filled>> dequeue();

 private:
  struct Unmap {
    std::size_t bytes;
    void operator()(std::byte* memory) const;
  };
  struct Buffer {
    std::unique_ptr<std::byte, Unmap> memory;
    Descriptor dmabuf, request;
  };
  Result<void> map(int index);
  Result<void> make_requests();
  void release();

  const DeviceNode& video_;
  const DeviceNode* media_;
  std::uint32_t queue_type_;
  std::vector<Buffer> buffers_;
  TimestampMark timestamp_mark_ = TimestampMark::ExposureEnd;
};

}  // namespace hdrcam
