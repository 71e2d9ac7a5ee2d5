// Raw frame -> exposed frame: codes scaled to 0..255 whatever the bit depth, black level removed, exposure
// relative to the clip's reference. Reentrant.
#pragma once

#include "capture/exposed_frame.h"
#include "hal/core/result.h"

namespace hdrcam {

// Settings common to all frames of a clip.
struct UnpackSettings {
  int bits = 8;  // significant bits of a raw code
  BlackLevel black_level;
  double reference_exposure = 1;          // E_ref, seconds x gains
  PixelLayout layout = PixelLayout::Rgb;  // Mono is the same as Rgb with one channel
};

// A Bayer mosaic is demosaiced (demosaic.h), mono is repeated on the three channels. `interval_s` is the time
// since the previous frame, seconds. Errors: BadExposure, naming the frame and the value.
Result<ExposedFrame> unpack(const RawFrame& raw, int index, double interval_s,
                            const UnpackSettings& settings);
// The same into a frame whose storage is reused; its content is undefined after an error.
Result<void> unpack_into(const RawFrame& raw, int index, double interval_s, const UnpackSettings& settings,
                         ExposedFrame& frame);

// Changes the black level of a frame unpacked with none.
void remove_black_level(ExposedFrame& frame, const BlackLevel& black_level);

}  // namespace hdrcam
