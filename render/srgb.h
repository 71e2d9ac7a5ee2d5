// Light and levels of a display: the curve of sRGB (IEC 61966-2-1), and the luminance of its primaries (ITU-R
// BT.709). Reentrant.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hal/core/image.h"

namespace hdrcam {

// Light, clamped to 0..1, to the level 0..1 that shows it.
inline float srgb_level(float light) {
  const float l = std::clamp(light, 0.f, 1.f);
  return l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1 / 2.4f) - 0.055f;
}
inline float srgb_light(float level) {
  return level <= 0.04045f ? level / 12.92f : std::pow((level + 0.055f) / 1.055f, 2.4f);
}

inline float luminance(float r, float g, float b) { return 0.2126f * r + 0.7152f * g + 0.0722f * b; }
// Of a pixel of [rgb, rows, cols], counted along the rows.
inline float luminance_at(const Image<float>& rgb, std::size_t pixel) {
  return luminance(rgb.plane(0)[pixel], rgb.plane(1)[pixel], rgb.plane(2)[pixel]);
}

}  // namespace hdrcam
