// Numbers of a ray's samples that the field has alike on the processor and on a graphics device (vulkan/,
// ../fit/vulkan/): C++ and GLSL (hal/gpu/element.glsl).
#ifdef __cplusplus
#pragma once

namespace hdrcam::ray_constants {
#endif

constexpr int kMaxSamples = 16;  // per ray

// Where samples are (ray_sampler.h), in inverse depth.
constexpr int kFewSamples = 4;        // fewer are spread over the whole range
constexpr int kWide = 3, kParts = 8;  // so many parts of the others are, and the rest around the guide:
constexpr float kBand = 0.03f, kBandPerDepth = 0.1f;  // so near to it, by its inverse depth
constexpr float kNearestSample = 0.995f;
constexpr float kOpticalRange = 20;  // optical length of the whole range

// What raw outputs mean (field_sample.h): bounds of the exponents of densities and radiances.
constexpr float kDensityBound = 12, kRadianceBound = 20;
// The prior of log density: of empty space, of a surface above it, and how thick that is, by its inverse
// depth.
constexpr float kEmptySpace = -6, kSurface = 8, kThickness = 0.01f, kThicknessPerDepth = 0.04f;
// The prior of the static density: a base that moves farther than `kStill` pixels is not static, by
// e^-kPerPixel for each pixel more, down to e^-kLeastStatic.
constexpr float kStill = 0.25f, kPerPixel = 4, kLeastStatic = 6;

// Added to the sum of both densities: keeps the share defined where both branches are empty.
constexpr float kEmptyDensity = 1e-6f;

#ifdef __cplusplus
}  // namespace hdrcam::ray_constants
#endif
