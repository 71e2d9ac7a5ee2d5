#include "hal/real/v4l2_stream.h"

#include <fcntl.h>
#include <linux/media.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>

namespace hdrcam {
namespace {

// A v4l2_buffer with room for the one plane of a multi-planar queue.
struct BufferCall {
  v4l2_buffer buffer{};
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes{};

  BufferCall(std::uint32_t queue_type, int index) {
    buffer.type = queue_type, buffer.memory = V4L2_MEMORY_MMAP,
    buffer.index = static_cast<std::uint32_t>(index);
    if (multi_planar())
      buffer.m.planes = planes.data(), buffer.length = static_cast<std::uint32_t>(planes.size());
  }
  BufferCall(const BufferCall&) = delete;
  BufferCall& operator=(const BufferCall&) = delete;

  bool multi_planar() const { return buffer.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE; }
  std::size_t length() const { return multi_planar() ? planes[0].length : buffer.length; }
  off_t offset() const { return multi_planar() ? planes[0].m.mem_offset : buffer.m.offset; }
  // A plane may begin with what is no picture; its bytes that are used count that, too.
  std::size_t begin() const { return multi_planar() ? planes[0].data_offset : 0; }
  std::size_t bytes_used() const { return multi_planar() ? planes[0].bytesused : buffer.bytesused; }
};

}  // namespace

V4l2Stream::~V4l2Stream() { release(); }

void V4l2Stream::Unmap::operator()(std::byte* memory) const { ::munmap(memory, bytes); }

void V4l2Stream::release() {
  if (buffers_.empty()) return;
  buffers_.clear();
  v4l2_requestbuffers none{};
  none.type = queue_type_, none.memory = V4L2_MEMORY_MMAP;
  (void)video_.ask(VIDIOC_REQBUFS, &none);
}

Result<void> V4l2Stream::allocate(int buffers) {
  release();
  v4l2_requestbuffers call{};
  call.type = queue_type_, call.memory = V4L2_MEMORY_MMAP, call.count = static_cast<std::uint32_t>(buffers);
  TRY(video_.demand(VIDIOC_REQBUFS, &call, "provide buffers"));
  if (buffers > 0 && call.count == 0)
    return Error{ErrorCode::Io,
                 fmt::format("'{}' has no memory for a buffer; choose a smaller size", video_.path())};
  if ((call.capabilities & V4L2_BUF_CAP_SUPPORTS_REQUESTS) == 0) media_ = nullptr;
  buffers_.resize(std::min<std::size_t>(call.count, VIDEO_MAX_FRAME));
  for (int i = 0; i < static_cast<int>(buffers_.size()); ++i) TRY(map(i));
  return {};
}

Result<void> V4l2Stream::map(int index) {
  BufferCall call(queue_type_, index);
  TRY(video_.demand(VIDIOC_QUERYBUF, &call.buffer, "describe its buffers"));
  const bool at_start = (call.buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  timestamp_mark_ = at_start ? TimestampMark::ExposureBegin : TimestampMark::ExposureEnd;
  void* memory =
      ::mmap(nullptr, call.length(), PROT_READ | PROT_WRITE, MAP_SHARED, video_.fd(), call.offset());
  if (memory == MAP_FAILED) return device_error(errno, video_.path(), "map its buffers");
  Buffer& buffer = buffers_[static_cast<std::size_t>(index)];
  buffer.memory = {static_cast<std::byte*>(memory), Unmap{call.length()}};
  v4l2_exportbuffer exported{};
  exported.type = queue_type_, exported.index = static_cast<std::uint32_t>(index),
  exported.flags = O_CLOEXEC | O_RDONLY;
  if (video_.ask(VIDIOC_EXPBUF, &exported) == 0) buffer.dmabuf = Descriptor(exported.fd);
  return {};
}

// A request left over from a stopped stream is not usable: every start makes new ones.
Result<void> V4l2Stream::make_requests() {
  for (Buffer& buffer : buffers_) {
    buffer.request = Descriptor();
    if (media_ == nullptr) continue;
    int fd = -1;
    TRY(media_->demand(MEDIA_IOC_REQUEST_ALLOC, &fd, "make media requests"));
    buffer.request = Descriptor(fd);
  }
  return {};
}

Result<void> V4l2Stream::start() {
  TRY(make_requests());
  int type = static_cast<int>(queue_type_);
  return video_.demand(VIDIOC_STREAMON, &type, "start its stream");
}

Result<void> V4l2Stream::stop() {
  int type = static_cast<int>(queue_type_);
  return video_.demand(VIDIOC_STREAMOFF, &type, "stop its stream");
}

Result<void> V4l2Stream::renew(int index) {
  if (::ioctl(request_fd(index), MEDIA_REQUEST_IOC_REINIT, nullptr) != 0)
    return device_error(errno, video_.path(), "use a media request again");
  return {};
}

Result<void> V4l2Stream::queue(int index) {
  BufferCall call(queue_type_, index);
  const int request = request_fd(index);
  if (request < 0) return video_.demand(VIDIOC_QBUF, &call.buffer, "queue a buffer");
  call.buffer.flags = V4L2_BUF_FLAG_REQUEST_FD, call.buffer.request_fd = request;
  TRY(video_.demand(VIDIOC_QBUF, &call.buffer, "queue a buffer"));
  if (::ioctl(request, MEDIA_REQUEST_IOC_QUEUE, nullptr) != 0)
    return device_error(errno, video_.path(), "queue a media request");
  return {};
}

Result<std::optional<V4l2Stream::Filled>> V4l2Stream::dequeue() {
  BufferCall call(queue_type_, 0);
  if (const int code = video_.ask(VIDIOC_DQBUF, &call.buffer); code != 0) {
    if (code == EAGAIN) return std::optional<Filled>();
    v4l2_capability any{};  // an unplugged camera's queue may answer otherwise than the camera
    if (video_.ask(VIDIOC_QUERYCAP, &any) == ENODEV) return device_error(ENODEV, video_.path(), "");
    return device_error(code, video_.path(), "deliver a frame");
  }
  const auto& stamp = call.buffer.timestamp;
  const std::size_t begin = std::min(call.begin(), call.bytes_used());
  return std::optional(Filled{static_cast<int>(call.buffer.index), call.buffer.sequence, call.buffer.flags,
                              begin, call.bytes_used() - begin,
                              std::chrono::seconds(stamp.tv_sec) + std::chrono::microseconds(stamp.tv_usec)});
}

}  // namespace hdrcam
