// The bytes of a captured buffer -> codes of a raw frame. Nothing is lost: Bayer stays Bayer, 10 bits stay 10
// bits, the response stays in; only what has no codes of its own (YUV, MJPEG) becomes RGB. No allocation once
// the picture has been of this size. Reentrant.
#pragma once

#include <optional>

#include "hal/camera.h"
#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/jpeg_decoder.h"

namespace hdrcam {

// What the codes of a format are, once unpacked.
struct PixelCodes {
  PixelLayout layout = PixelLayout::Rgb;
  int bits = 8;
  bool linear = false;  // raw sensor codes: proportional to light above the black level
};
PixelCodes codes_of(PixelFormat format);

struct PixelUnpackSettings {
  std::optional<YuvRange> yuv_range;  // none: as the camera states it
  DecodeJpeg decode_jpeg;             // jpeg_decoder(); only needed for Mjpeg
};

// codes: [channels(layout), rows, cols], 0 .. 2^bits - 1. A stride of 0 means tightly packed rows. Errors:
// Corrupt for a buffer that is shorter than its mode says or a JPEG that does not decode; Unsupported for
// Mjpeg without a decoder; Invalid for odd sizes of a format that shares samples between neighbours.
Result<void> unpack_pixels(const CapturedBuffer& buffer, const PixelUnpackSettings& settings,
                           Image<std::uint16_t>& codes);

}  // namespace hdrcam
