#include "firmware_host/sinks/scene_files/depth_pictures.h"

#include <cmath>

#include "firmware_host/sinks/numbered_files.h"
#include "hal/recording/png_image.h"

namespace hdrcam {
namespace {

PngImage picture_of(const HdrFrame& frame) {
  constexpr float kPerUnit = 1000, kLargest = 65535;
  PngImage picture{.bits_per_sample = 16, .samples = {}};
  picture.samples.reshape(1, frame.radiance.rows(), frame.radiance.cols());
  picture.samples.fill(0);
  for (std::size_t i = 0; i < frame.depth.size(); ++i) {
    const float code = std::round(kPerUnit * frame.depth.samples()[i]);
    if (code >= 1 && code <= kLargest) picture.samples.samples()[i] = static_cast<std::uint16_t>(code);
  }
  return picture;
}

}  // namespace

Result<std::unique_ptr<FrameSink>> create_depth_pictures(Storage& storage, std::string_view pattern) {
  return create_numbered_files(storage, "--depth", pattern, ".png",
                               [](const EmittedFrame& frame, Storage& disk, const std::string& path) {
                                 return write_png(disk, path, picture_of(frame.hdr));
                               });
}

}  // namespace hdrcam
