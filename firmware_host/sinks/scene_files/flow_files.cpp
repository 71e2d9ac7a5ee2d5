#include "firmware_host/sinks/scene_files/flow_files.h"

#include <bit>
#include <cstdint>
#include <cstring>

#include "firmware_host/sinks/numbered_files.h"

namespace hdrcam {

static_assert(std::endian::native == std::endian::little);

std::vector<std::byte> encode_flo(const Image<float>& flow, int rows, int cols) {
  HDRCAM_CHECK((flow.empty() || (flow.channels() == 2 && flow.rows() == rows && flow.cols() == cols)));
  const std::size_t pixels = pixel_count(rows, cols);
  std::vector<float> vectors(2 * pixels, kUnknownFlow);
  for (std::size_t i = 0; !flow.empty() && i < pixels; ++i)
    vectors[2 * i] = flow.plane(0)[i], vectors[2 * i + 1] = flow.plane(1)[i];
  const std::int32_t size[2] = {cols, rows};
  constexpr std::size_t kTag = 4;
  std::vector<std::byte> bytes(kTag + sizeof size + vectors.size() * sizeof(float));
  std::memcpy(bytes.data(), "PIEH", kTag);
  std::memcpy(bytes.data() + kTag, size, sizeof size);
  std::memcpy(bytes.data() + kTag + sizeof size, vectors.data(), vectors.size() * sizeof(float));
  return bytes;
}

Result<std::unique_ptr<FrameSink>> create_flow_files(Storage& storage, std::string_view flag,
                                                     std::string_view pattern,
                                                     Image<float> HdrFrame::*layer) {
  return create_numbered_files(
      storage, flag, pattern, ".flo",
      [layer](const EmittedFrame& frame, Storage& disk, const std::string& path) {
        const Image<float>& radiance = frame.hdr.radiance;
        return write_whole(disk, path, encode_flo(frame.hdr.*layer, radiance.rows(), radiance.cols()),
                           Durability::WrittenBack);
      });
}

}  // namespace hdrcam
