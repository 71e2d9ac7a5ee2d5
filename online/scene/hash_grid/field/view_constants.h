// Numbers of window space (view_geometry.h) that a graphics device (vulkan/) has alike: C++ and GLSL
// (hal/gpu/element.glsl).
#ifdef __cplusplus
#pragma once

namespace hdrcam::view_constants {
using Real = double;
#else
#define Real float
#endif

constexpr Real kNearest = 0.05;                          // z over the near distance, at least
constexpr Real kDepthOffset = 0.01, kDepthScale = 0.98;  // of d, along inverse depth

#ifdef __cplusplus
}  // namespace hdrcam::view_constants
#endif
