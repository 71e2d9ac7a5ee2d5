#include "firmware_host/sinks/preview.h"

#include <utility>

#include "firmware_host/sinks/frame_pattern.h"
#include "render/png.h"
#include "render/tone_curve.h"

namespace hdrcam {
namespace {

class Preview : public FrameSink {
 public:
  Preview(Storage& storage, FramePattern pattern) : storage_(storage), pattern_(std::move(pattern)) {}

  Result<void> emit(const EmittedFrame& frame) override {
    const Image<float>& radiance = frame.hdr.radiance;
    const auto png = TRY(encode_png(tone_mapped(radiance, tone_.follow(radiance))));
    return write_whole(storage_, pattern_.path(frame.hdr.facts.sequence), png);
  }

 private:
  Storage& storage_;
  const FramePattern pattern_;
  ToneAdaptation tone_;
};

}  // namespace

Result<std::unique_ptr<FrameSink>> create_preview(Storage& storage, std::string_view pattern) {
  auto parsed = TRY(FramePattern::parse("--preview", pattern, ".png"));
  TRY(storage.make_directories(parsed.folder()));
  return std::unique_ptr<FrameSink>(std::make_unique<Preview>(storage, std::move(parsed)));
}

}  // namespace hdrcam
