#include "firmware_host/sinks/ldr_frames.h"

#include <vector>

#include "firmware_host/sinks/hdr_video.h"
#include "firmware_host/sinks/numbered_files.h"
#include "firmware_host/sinks/sink_name.h"
#include "render/png.h"
#include "render/views/re_exposure.h"

namespace hdrcam {
namespace {

Result<void> write_picture(const EmittedFrame& frame, Storage& storage, const std::string& path) {
  const auto png = TRY(encode_png(codes_of_light(frame.hdr.radiance)));
  return write_whole(storage, path, png, Durability::WrittenBack);
}

Result<std::unique_ptr<FrameSink>> open_video(const SinkRequest& request) {
  return create_display_video(request.storage, request.path, request.camera.framerate_hz, request.video);
}

Result<std::unique_ptr<FrameSink>> open_frames(const SinkRequest& request) {
  if (video_container_of(request.path)) return open_video(request);
  return create_numbered_files(request.storage, "--output", request.path, ".png", write_picture);
}

}  // namespace

std::span<const SinkKind> ldr_sink_kinds() {
  static const std::vector<SinkKind> kinds = [] {
    std::vector<SinkKind> all(sink_kinds().begin(), sink_kinds().end());
    for (SinkKind& kind : all) {
      if (kind.name == sink_name::kVideo) kind.open = open_video;
      if (kind.name == sink_name::kFrames) kind.open = open_frames, kind.extension = ".png";
    }
    return all;
  }();
  return kinds;
}

}  // namespace hdrcam
