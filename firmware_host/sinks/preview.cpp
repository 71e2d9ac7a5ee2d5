#include "firmware_host/sinks/preview.h"

#include "firmware_host/sinks/numbered_files.h"
#include "render/png.h"
#include "render/tone_curve.h"

namespace hdrcam {

Result<std::unique_ptr<FrameSink>> create_preview(Storage& storage, std::string_view pattern) {
  const auto write = [tone = ToneAdaptation()](const EmittedFrame& frame, Storage& disk,
                                               const std::string& path) mutable -> Result<void> {
    const Image<float>& radiance = frame.hdr.radiance;
    const auto png = TRY(encode_png(tone_mapped(radiance, tone.follow(radiance))));
    return write_whole(disk, path, png, Durability::WrittenBack);
  };
  return create_numbered_files(storage, "--preview", pattern, ".png", write);
}

}  // namespace hdrcam
