// How the state's kernels lay out what they share; the twin is online/state/fusion.cpp.
//   state    [radiance rgb, variance rgb]
//   samples  [radiance rgb, weight rgb, comparable rgb, blur rgb]
//   motion   [dx, dy, confidence]
//   tables   radiance [3][kCodes] by code, variance [3][kRoots] by the root of relative exposure,
//            the most that is hidden of a texture [3][kRoots] by the same (ExposureTables)
#include "online/state/pass_constants.h"

const int kVariance = 3;
const int kWeight = 3, kComparable = 6, kBlur = 9;
const int kConfidence = 2;
