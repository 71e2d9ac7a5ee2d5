// Numbers that the state's passes have alike on the processor and on a graphics device (vulkan/): C++ and
// GLSL (hal/gpu/element.glsl).
#ifdef __cplusplus
#pragma once

namespace hdrcam::pass_constants {
#endif

// Tables of ExposureTables: radiance by code; variance and code by kSegments sqrt(relative exposure).
constexpr int kCodes = 257, kSegments = 2048, kRoots = kSegments + 2;

constexpr float kTiny = 1e-20f;    // keeps quotients finite
constexpr float kClipped = 0.05f;  // weight below which a sample is only a bound

// Gate.
constexpr float kHardlyCompared = 0.05f;  // channels: what was compared less hardly disagrees
constexpr float kBound = 0.9f;            // of a clipped sample: what is darker contradicts it
constexpr float kBelowBound = 0.15f;      // of that: so far below it, 1/e of the trust is left

// Update: squared signal over noise from which on a sample is more than a bound.
constexpr float kLeastSignal2 = 1e-5f;
// Ringing: the relative exposure at which the state is sure to be clipped, and far beyond, by so many
// standard deviations; how many times faster the weight falls there.
constexpr float kSurelyClipped = 1.25f, kFarClipped = 2.5f, kSureSigmas = 2, kRingingFades = 3;
// A later frame's sample against a bound, in relative exposures: from which on what is bounded would be
// clipped there, and below which the sample shows something else.
constexpr float kAtClip = 0.98f, kElse = 0.5f;

// Age: least divisor of the variance where the gate is closed.
constexpr float kLeastGate = 1e-4f;
// What a warp adds, of misalignment^2 times the local contrast: by a motion of a pixel and more, and half way
// between pixels.
constexpr float kByMotion = 0.3f, kByInterpolation = 0.7f;

// Blur of an exposure.
constexpr float kLeastBlur = 0.6f;            // pixels: a shorter one changes nothing visible
constexpr int kLeastTaps = 3, kMostTaps = 9;  // instants per exposure
constexpr float kTapsPerPixel = 0.7f;
constexpr float kLongest = 64;  // pixels: keeps the product finite; there are kMostTaps long before

// Residuals of samples.
constexpr float kUnclipped = 0.5f;       // least weight of a sample that is looked at
constexpr float kLeastExposure = 1e-7f;  // relative: the bins end before it
constexpr float kBinsPerStop = 2;

#ifdef __cplusplus
}  // namespace hdrcam::pass_constants
#endif
