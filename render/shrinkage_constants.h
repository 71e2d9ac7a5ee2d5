// Numbers that shrinkage has alike on the processor and on a graphics device (vulkan/): C++ and GLSL
// (hal/gpu/element.glsl).
#ifdef __cplusplus
#pragma once

namespace hdrcam {
#endif

constexpr int kShrinkageTile = 8, kShrinkageStep = 4;  // pixels

constexpr float kMaxLogVariance = 0.25f;  // of a channel's logarithm: more is not known of a dark pixel
constexpr float kLeastPower = 1e-12f;     // of a coefficient: keeps its gain finite
constexpr float kLeastNoise = 1e-6f;      // of a tile: keeps its weight finite

// Opponent colours, orthonormal: luminance (1 1 1), red - blue (-1 0 1), green against both (1 -2 1).
constexpr float kOfLuminance = 0.57735f, kOfRedBlue = 0.70711f, kOfBoth = 0.40825f, kOfGreen = 0.81650f;

#ifdef __cplusplus
}  // namespace hdrcam
#endif
