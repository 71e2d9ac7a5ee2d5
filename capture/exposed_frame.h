// A frame whose exposure is known: the output of capture/ and the input of the fit. Codes are linear in the
// file's codes, scaled so that white is 255 and a stated black level is 0 (exposed_stream.h), or
// their square roots (companding.h); the camera's response is still applied. Exposures are relative to the
// clip's reference E_ref (geometric mean of the cycle), so that radiance L = 1 saturates the reference
// exposure (docs/architecture.md). Move-only value.
#pragma once

#include <utility>

#include "hal/core/frame.h"
#include "hal/core/image.h"
#include "hal/core/white_level.h"

namespace hdrcam {

constexpr float kMaxCode = 255;  // of ExposedFrame::codes, whatever the bit depth of the file

struct ExposedFrame {
  FrameFacts facts;
  int index = 0;                  // 0, 1, 2.. in the order of arrival; facts.sequence may have gaps
  float exposure = 1;             // E / E_ref
  double reference_exposure = 1;  // E_ref, seconds x gains
  double interval_s = 0;          // since the frame before; not above 0: unknown
  // Share of the motion that blurs: exposure time over interval_s, 0..1, and more where a long exposure and
  // the short one before it end a frame apart; in online/ what counts of it (online/state/shown_blur.h).
  float blur_fraction = 0;
  WhiteLevel white{};  // what the camera wrote where codes are 255, before a black level was removed
  Image<float> codes;  // [rgb, rows, cols] float, 0..kMaxCode

  ExposedFrame without_codes() const {
    return {facts, index, exposure, reference_exposure, interval_s, blur_fraction, white, {}};
  }
};

// All but the codes; `to` keeps its own.
inline void copy_all_but_codes(const ExposedFrame& from, ExposedFrame& to) {
  Image<float> codes = std::move(to.codes);
  to = from.without_codes();
  to.codes = std::move(codes);
}

// `to` keeps its memory.
inline void copy(const ExposedFrame& from, ExposedFrame& to) {
  copy_all_but_codes(from, to);
  to.codes.copy_from(from.codes);
}

}  // namespace hdrcam
