// When a code says nothing about the light, because it may have been cut off at either end of the range. One
// place for all who ask; the limits differ, as the questions do: a code that is good enough to weigh down
// gently is not good enough to compare two pictures by. In codes of 255, where nothing else is said. The
// values were settled by ablation on clips with ground truth (docs/decisions.md).
#pragma once

namespace hdrcam::clip_policy {

struct UsableCodes {
  float darkest, brightest;
};

// Ratio of two pictures' exposures: any code of a box from here on may have been cut off. How dark is too
// dark depends on what is known of the response (photometry.h).
inline constexpr float kPhotometryClipped = 250;

// Means of a picture's cells, to see whether two pictures show the same scene.
inline constexpr UsableCodes kSameScene{3, 250};

// Matched codes for the response: neither black nor saturated. The least code is 1, less rounding.
inline constexpr UsableCodes kResponseMatch{0.99f, 252.7f};

// Pairs of samples for the noise: far enough from the ends that noise is not cut on one side; of the darker
// one as the brighter one predicts it.
inline constexpr UsableCodes kNoisePair{4, 245};

// A pixel that shows no texture to match: all its channels beyond one end. Stricter where a share of clipped
// pixels decides between two motions than where one pixel's agreement is rated.
inline constexpr UsableCodes kMotionShare{4, 246}, kMotionRating{3, 248};

// The state's samples: the weight falls from 1 to 0 between these codes.
inline constexpr float kFadeBegin = 220, kFadeEnd = 250;
// Comparisons of a sample with the state: stricter, at both ends.
inline constexpr float kCompareFadeBegin = 200, kCompareFadeEnd = 235;
inline constexpr float kCompareDarkBegin = 1, kCompareDarkEnd = 4;

// The field's photometric loss, as values 0..1: a measured value beyond is a bound, not a value.
inline constexpr UsableCodes kLossOfOne{0.004f, 0.985f};

}  // namespace hdrcam::clip_policy
