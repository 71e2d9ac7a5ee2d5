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

// cos(k pi / 16) / 2, of which the orthonormal transform of eight pixels is made.
constexpr float kCos1 = 0.49039264f, kCos2 = 0.46193977f, kCos3 = 0.41573481f, kCos4 = 0.35355339f,
                kCos5 = 0.27778512f, kCos6 = 0.19134172f, kCos7 = 0.09754516f;

#ifdef __cplusplus
}  // namespace hdrcam
#endif
