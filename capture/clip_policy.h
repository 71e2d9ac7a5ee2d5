// The codes that are too near to the ends of their range to measure light, because they may be clipped. All
// limits stand here; they differ because their uses differ: a code that may still enter a weighted mean may
// be too near to clipping to compare two pictures. Unit: codes of 255 unless stated otherwise. The values
// were settled by ablation on clips with ground truth (docs/decisions). Constants.
#pragma once

namespace hdrcam::clip_policy {

struct UsableCodes {
  float darkest, brightest;
};

// Ratio of two pictures' exposures: a code from here on may be clipped. The dark limit depends on how well
// the response is known (photometric_response.h).
inline constexpr float kPhotometryClipped = 250;

// Means of a picture's cells, for the check whether two pictures show the same scene.
inline constexpr UsableCodes kSameScene{3, 250};

// Matched codes for the response: neither black nor saturated. The least code is 1, less rounding.
inline constexpr UsableCodes kResponseMatch{0.99f, 252.7f};

// Pairs of samples for the noise estimate: far enough from the ends that noise is not clipped on one side.
// The limits hold for the darker sample as the brighter one predicts it.
inline constexpr UsableCodes kNoisePair{4, 245};

// The spread of a tile's codes, as the sensor's noise: none of its pixels may reach an end, where noise is
// cut.
inline constexpr UsableCodes kNoiseTile{0, 252};

// Texture that motion blur may have taken away: a code from here on is clipped, or mixed with what is. The
// dark limit depends on the exposures (online/response/blur_between.cpp).
inline constexpr float kBlurClipped = 248;

// A pixel has no texture to match where all its channels are beyond one end. The limit is stricter where a
// share of clipped pixels decides between two motions than where the agreement of one pixel is rated.
inline constexpr UsableCodes kMotionShare{4, 246}, kMotionRating{3, 248};

// The state's samples: the weight falls from 1 to 0 between these codes.
inline constexpr float kFadeBegin = 220, kFadeEnd = 250;
// Comparisons of a sample with the state: stricter, at both ends.
inline constexpr float kCompareFadeBegin = 200, kCompareFadeEnd = 235;
inline constexpr float kCompareDarkBegin = 1, kCompareDarkEnd = 4;

// What no exposure shows above this code is black: it can be anything below.
inline constexpr float kBlack = 2;

// The field's photometric loss, values 0..1: a measured value beyond these is a bound, not a measurement.
inline constexpr UsableCodes kLossOfOne{0.004f, 0.985f};

}  // namespace hdrcam::clip_policy
