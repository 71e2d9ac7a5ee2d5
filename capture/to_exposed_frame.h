// Raw frame -> exposed frame: codes scaled to 0..255 whatever the bit depth and the code of white,
// demosaiced, exposure relative to the clip's reference; and the removal of a black level. Reentrant.
#pragma once

#include <algorithm>

#include "capture/exposed_frame.h"
#include "hal/core/result.h"

namespace hdrcam {

// What a raw code of so many bits is multiplied with.
inline float code_scale(int bits) {
  return static_cast<float>(kMaxCode / static_cast<double>((1 << bits) - 1));
}
inline float scaled_code(std::uint16_t code, float scale) {
  return std::min(kMaxCode, static_cast<float>(code) * scale);
}

// Settings common to all frames of a clip.
struct ExposedFrameSettings {
  int bits = 8;                           // significant bits of a raw code
  double reference_exposure = 1;          // E_ref, seconds x gains
  double frame_s = 0;                     // from frame to frame, as the camera states it; 0: unknown
  PixelLayout layout = PixelLayout::Rgb;  // Mono is the same as Rgb with one channel
  WhiteLevel white{};                     // becomes 255; not of a mosaic
};

// A Bayer mosaic is demosaiced (demosaic.h), mono is repeated on the three channels. `interval_s` is the time
// since the previous frame, seconds. The frame's storage is reused; its content is undefined after an error.
// Errors: those of check_exposure().
Result<void> to_exposed_frame(const RawFrame& raw, int index, double interval_s,
                              const ExposedFrameSettings& settings, ExposedFrame& frame);

// BadExposure where the exposure is not positive and finite, naming the frame and the value.
Result<void> check_exposure(const FrameFacts& facts);
// Codes at the black level become 0; the largest code stays 255. Once per frame.
void remove_black_level(ExposedFrame& frame, const BlackLevel& black_level);

}  // namespace hdrcam
