// Numbers that the dense flow has alike on the processor and on a graphics device (vulkan/): C++ and GLSL
// (hal/gpu/element.glsl).
#ifdef __cplusplus
#pragma once

namespace hdrcam::flow_constants {
#endif

constexpr int kPatchSize = 8;     // pixels; one row of a patch is one register of eight lanes
constexpr int kOutside = 16;      // pixels that a patch may leave the picture by
constexpr int kStrip = 8;         // rows of patches that share one sweep
constexpr float kNowhere = 1e9f;  // pixels; a component of a vector that is not there

// Descent.
constexpr float kFlat = 4;                   // codes^2 per pixel^2: the texture of a flat patch
constexpr float kExpected2 = 0.18f * 0.18f;  // pixels^2
constexpr float kLeastStep2 = 1e-4f;         // pixels^2
constexpr float kFarthest2 = 64;             // pixels^2: farther off, it is another place that looks alike
// What makes another guess the better one, of its error, and codes^2 over the patch: noise makes one of two
// places that much better.
constexpr float kBetterShare = 0.25f, kLeastBetter = 32;

// What is looked for far away.
constexpr int kReach = 3;              // up to a third of the picture away, each way, and
constexpr int kMostReach = 96;         // pixels: a long strip has too many places to compare all
constexpr float kLeastTexture = 2500;  // codes^2 over the patch: with less, much looks alike
constexpr float kExplained = 0.5f;     // of the texture: a patch whose error is below is where it should be
constexpr float kFound = 0.35f;        // of the texture, and
constexpr float kFarBetter = 0.5f;     // of the error: what the error at another place must be below
constexpr float kWorstError = 1e30f;   // codes^2 over the patch

// Refinement.
constexpr float kPictures = 0.5f;         // against smoothness
constexpr float kLeastSlope2 = 40;        // (codes per pixel)^2
constexpr float kSmallest = 0.05f;        // pixels
constexpr float kLeastDistance2 = 1e-2f;  // pixels^2
constexpr float kRelaxed = 1.3f;

#ifdef __cplusplus
}  // namespace hdrcam::flow_constants
#endif
