// The frames that FFmpeg decoded from one file -> their codes as RGB or mono, turned upright. The depth of
// what was RGB or mono stays; Y'CbCr of 8 bits becomes RGB of 10, so that rounding adds nothing, deeper ones
// keep their depth. Thread-bound; no allocation after the first frame.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/core/frame.h"
#include "hal/footage/orientation.h"
#include "hal/recording/libav.h"
#include "hal/video/picture_converter.h"

namespace hdrcam {

class DecodedCodes {
 public:
  // The first frame says how the codes of all become RGB; codec: which decoded it. Error: Unsupported, whose
  // text goes on after the name of the file.
  Result<void> begin(const AVFrame& frame, AVCodecID codec);
  bool begun() const { return pixel_format_ != AV_PIX_FMT_NONE; }
  // Whether a later frame has the first one's size and format.
  bool is_like_first(const AVFrame& frame) const;
  // codes: [channels, rows, cols], upright, reused. Errors: those of PictureConverter::convert.
  Result<void> take(const AVFrame& frame, Orientation orientation, Image<std::uint16_t>& codes);

  PixelLayout layout() const {
    return from_.colors == PictureColors::Grey ? PixelLayout::Mono : PixelLayout::Rgb;
  }
  int bits() const;
  // As FFmpeg names it: "yuv420p".
  const char* format_name() const;

 private:
  Result<void> take_format(const AVFrame& frame, AVCodecID codec);
  Result<void> open_converter();
  void unpack(const AVFrame& frame);

  AVPixelFormat pixel_format_ = AV_PIX_FMT_NONE;
  PictureFormat from_;  // sides are multiples of the chroma's
  std::optional<PictureConverter> converter_;
  Image<std::uint16_t> unpacked_, converted_;  // rows at multiples of 64 bytes
};

}  // namespace hdrcam
