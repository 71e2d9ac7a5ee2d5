// From scene-linear radiance to 8-bit display codes: one global curve, the same for each channel, so that
// bright colours saturate to white as on film.
//   x = kKey L / mid,   y = x (1 + x / w^2) / (1 + x),   w = kKey white / mid,   code = 255 sRGB(min(y, 1))
// (Reinhard et al. 2002, eq. 2 and 4).
// `mid` is shown as a mid grey, `white` as display white. The curve belongs to the clip, not to the frame:
// ToneAdaptation sets it from the first frame and then changes it by at most a hundredth of a stop per frame,
// so a static scene is shown without flicker for any exposure schedule.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/core/image.h"

namespace hdrcam {

struct ToneAnchors {
  float mid = 0.18f;  // radiance shown as mid grey, 2^-20 .. 2^20
  float white = 1;    // radiance shown as white, 4 mid .. 2^24
};

// The anchors of one picture: mid = geometric mean of its luminance, white = its 99.5th percentile with half
// a stop of headroom. radiance: [rgb, rows, cols]; pixels that are not finite and positive are left out;
// nullopt where none remain (a black picture).
std::optional<ToneAnchors> tone_anchors(const Image<float>& radiance);

// Immutable value, reentrant. Evaluation is a table of 64 segments per octave over 2^-24 .. 2^24.
class ToneCurve {
 public:
  static constexpr float kKey = 0.25f;  // shows `mid` as 0.2 of white's light, code 124

  explicit ToneCurve(ToneAnchors anchors);
  // radiance -> code, monotone; 0 for what is not a positive number, 255 for +inf
  std::uint8_t code(float radiance) const { return static_cast<std::uint8_t>(level(radiance) + 0.5f); }
  // The code before it is rounded, 0..255.
  float level(float radiance) const;
  const ToneAnchors& anchors() const { return anchors_; }

 private:
  static constexpr int kSegments = 64, kLowestOctave = -24, kOctaves = 48;

  ToneAnchors anchors_;
  std::array<float, kSegments * kOctaves + 1> codes_{};
};

// [rgb, rows, cols] radiance -> [rgb, rows, cols] sRGB codes
Image<std::uint8_t> tone_mapped(const Image<float>& radiance, const ToneCurve& curve);

// Thread-bound: one per clip, fed with every frame in order.
class ToneAdaptation {
 public:
  static constexpr float kMaxStep = 0.01f;  // stops per frame

  // Adapts to the frame and returns the curve for it, which is valid until the next call.
  const ToneCurve& follow(const Image<float>& radiance);

 private:
  ToneCurve curve_{ToneAnchors{}};
  bool measured_ = false;  // false until the first frame that is not black
};

}  // namespace hdrcam
