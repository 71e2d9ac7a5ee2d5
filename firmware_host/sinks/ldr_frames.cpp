#include "firmware_host/sinks/ldr_frames.h"

#include <utility>
#include <vector>

#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/hdr_video.h"
#include "render/png.h"
#include "render/views/re_exposure.h"

namespace hdrcam {
namespace {

class LdrPictures : public FrameSink {
 public:
  LdrPictures(Storage& storage, FramePattern pattern) : storage_(storage), pattern_(std::move(pattern)) {}

  Result<void> emit(const EmittedFrame& frame) override {
    const auto png = TRY(encode_png(codes_of_light(frame.hdr.radiance)));
    return write_whole(storage_, pattern_.path(frame.hdr.facts.sequence), png);
  }

 private:
  Storage& storage_;
  const FramePattern pattern_;
};

Result<std::unique_ptr<FrameSink>> open_frames(const SinkRequest& request) {
  if (video_container_of(request.path))
    return create_display_video(request.storage, request.path, request.camera.framerate_hz, request.video);
  auto parsed = TRY(FramePattern::parse("--output", request.path, ".png"));
  TRY(request.storage.make_directories(parsed.folder()));
  return std::unique_ptr<FrameSink>(std::make_unique<LdrPictures>(request.storage, std::move(parsed)));
}

}  // namespace

std::span<const SinkKind> ldr_sink_kinds() {
  static const std::vector<SinkKind> kinds = [] {
    std::vector<SinkKind> all(sink_kinds().begin(), sink_kinds().end());
    for (SinkKind& kind : all)
      if (std::string_view(kind.name) == "frames" || std::string_view(kind.name) == "video")
        kind.open = open_frames;
    return all;
  }();
  return kinds;
}

}  // namespace hdrcam
