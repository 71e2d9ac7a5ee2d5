#include "firmware_host/sinks/scene_files/depth_pictures.h"

#include <cmath>
#include <utility>

#include "firmware_host/sinks/frame_pattern.h"
#include "hal/recording/png_image.h"

namespace hdrcam {
namespace {

class DepthPictures : public FrameSink {
 public:
  DepthPictures(Storage& storage, FramePattern pattern) : storage_(storage), pattern_(std::move(pattern)) {}

  Result<void> emit(const EmittedFrame& frame) override {
    constexpr float kPerUnit = 1000, kLargest = 65535;
    const HdrFrame& hdr = frame.hdr;
    picture_.bits_per_sample = 16;
    picture_.samples.reshape(1, hdr.radiance.rows(), hdr.radiance.cols());
    picture_.samples.fill(0);
    for (std::size_t i = 0; i < hdr.depth.size(); ++i) {
      const float code = std::round(kPerUnit * hdr.depth.samples()[i]);
      if (code >= 1 && code <= kLargest) picture_.samples.samples()[i] = static_cast<std::uint16_t>(code);
    }
    return write_png(storage_, pattern_.path(hdr.facts.sequence), picture_);
  }

 private:
  Storage& storage_;
  const FramePattern pattern_;
  PngImage picture_;
};

}  // namespace

Result<std::unique_ptr<FrameSink>> create_depth_pictures(Storage& storage, std::string_view pattern) {
  auto parsed = TRY(FramePattern::parse("--depth", pattern, ".png"));
  TRY(storage.make_directories(parsed.folder()));
  return std::unique_ptr<FrameSink>(std::make_unique<DepthPictures>(storage, std::move(parsed)));
}

}  // namespace hdrcam
