// Pictures in a graphics device's memory: planar like Image<float>, [channels, rows, cols]. Move-only;
// thread-bound like the device, which outlives them.
#pragma once

#include "hal/core/image.h"
#include "hal/gpu/gpu_device.h"

namespace hdrcam {

struct GpuPicture {
  std::unique_ptr<GpuBuffer> buffer;
  int channels = 0, rows = 0, cols = 0;

  static Result<GpuPicture> make(GpuDevice& device, int channels, int rows, int cols) {
    const std::size_t samples =
        static_cast<std::size_t>(channels) * static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
    return GpuPicture{TRY(device.buffer(samples * sizeof(float))), channels, rows, cols};
  }
  const GpuBuffer* operator*() const { return buffer.get(); }
  // One element per pixel of each plane.
  GpuGrid grid() const { return {cols, rows, channels}; }
  GpuGrid pixels() const { return {cols, rows, 1}; }
  std::size_t bytes_before(int plane) const {
    return sizeof(float) * static_cast<std::size_t>(plane) * static_cast<std::size_t>(rows) *
           static_cast<std::size_t>(cols);
  }
};

// Into all planes of `to`, or into those from `first` on.
inline void upload(GpuWork& work, const Image<float>& from, const GpuPicture& to, int first = 0) {
  HDRCAM_CHECK(first + from.channels() <= to.channels && from.rows() == to.rows && from.cols() == to.cols);
  work.upload(std::as_bytes(from.samples()), *to.buffer, to.bytes_before(first));
}
// All planes, or `channels` of them from `first` on. `to` takes its shape at once, its samples with finish().
inline void download(GpuWork& work, const GpuPicture& from, int first, int channels, Image<float>& to) {
  HDRCAM_CHECK_LE(first + channels, from.channels);
  to.reshape(channels, from.rows, from.cols);
  work.download(*from.buffer, from.bytes_before(first), std::as_writable_bytes(to.samples()));
}
inline void download(GpuWork& work, const GpuPicture& from, Image<float>& to) {
  download(work, from, 0, from.channels, to);
}

}  // namespace hdrcam
