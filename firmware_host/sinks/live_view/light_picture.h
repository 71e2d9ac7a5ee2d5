// HDR frames as pictures that keep their light, for browsers on HDR displays: PNG files whose cICP chunk (PNG
// Specification, third edition, 11.3.2.6) says BT.2020 and PQ. 10 bits of PQ as in HDR10, widened to the
// file's 16; radiance 1 is shown as `white_nits`, as in videos (render/display_light.h). A picture is encoded
// once, however many people look at it. Thread-bound.
#pragma once

#include <cstdint>
#include <optional>

#include "firmware_host/sinks/live_view/newest_frame.h"
#include "firmware_host/sinks/video_options.h"
#include "firmware_host/web/http_server.h"
#include "hal/video/picture_converter.h"

namespace hdrcam {

class LightPicture {
 public:
  explicit LightPicture(const VideoOptions& options) : options_(options) {}

  // exposure_ev: brighter by so many stops. Errors: those of the encoder.
  Result<HttpBody> png(const ShownFrame& frame, double exposure_ev);

 private:
  Result<void> fit_to(int rows, int cols);
  Result<void> convert(const Image<float>& radiance);

  const VideoOptions options_;
  std::optional<PictureConverter> converter_;  // for pictures of this size:
  int rows_ = 0, cols_ = 0;
  Image<float> light_;                     // [rgb, rows, cols and more] cd/m2, rows at multiples of 64 bytes
  Image<std::uint16_t> signal_;            // as light_: PQ of 10 bits
  std::optional<std::uint64_t> sequence_;  // of the frame that is encoded, at exposure_ev_
  double exposure_ev_ = 0;
  HttpBody encoded_;
};

}  // namespace hdrcam
