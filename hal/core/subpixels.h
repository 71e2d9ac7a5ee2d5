// How places between pixels are rounded, alike on the processor (picture_lanes.h) and on a graphics device
// (online/pictures/vulkan/): C++ and GLSL (hal/gpu/element.glsl).
#ifdef __cplusplus
#pragma once

namespace hdrcam::subpixels {
#endif

constexpr int kOutside = 4;  // pixels: what is farther outside a picture is no farther than this
constexpr int kSubpixels = 32, kShift = 5;  // parts of a pixel, 1 << kShift

#ifdef __cplusplus
}  // namespace hdrcam::subpixels
#endif
