#include "firmware_host/sinks/scene_files/flow_files.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "firmware_host/sinks/frame_pattern.h"

namespace hdrcam {
namespace {

static_assert(std::endian::native == std::endian::little);

class FlowFiles : public FrameSink {
 public:
  FlowFiles(Storage& storage, FramePattern pattern, Image<float> HdrFrame::*layer)
      : storage_(storage), pattern_(std::move(pattern)), layer_(layer) {}

  Result<void> emit(const EmittedFrame& frame) override {
    const Image<float>& radiance = frame.hdr.radiance;
    return write_whole(storage_, pattern_.path(frame.hdr.facts.sequence),
                       encode_flo(frame.hdr.*layer_, radiance.rows(), radiance.cols()));
  }

 private:
  Storage& storage_;
  const FramePattern pattern_;
  Image<float> HdrFrame::*const layer_;
};

}  // namespace

std::vector<std::byte> encode_flo(const Image<float>& flow, int rows, int cols) {
  CHECK((flow.empty() || (flow.channels() == 2 && flow.rows() == rows && flow.cols() == cols)));
  const std::size_t pixels = static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
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
  auto parsed = TRY(FramePattern::parse(flag, pattern, ".flo"));
  TRY(storage.make_directories(parsed.folder()));
  return std::unique_ptr<FrameSink>(std::make_unique<FlowFiles>(storage, std::move(parsed), layer));
}

}  // namespace hdrcam
