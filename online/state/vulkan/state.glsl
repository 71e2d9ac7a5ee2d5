// How the state's kernels lay out what they share; the twin is online/state/fusion.cpp.
//   state    [radiance rgb, variance rgb]
//   samples  [radiance rgb, weight rgb, comparable rgb, blur rgb]
//   motion   [dx, dy, confidence]
//   tables   radiance [3][257] by code, variance [3][2050] by the root of relative exposure (ExposureTables)
const int kVariance = 3;
const int kWeight = 3, kComparable = 6, kBlur = 9;
const int kConfidence = 2;
const int kCodes = 257, kRoots = 2050, kSegments = 2048;
const float kTiny = 1e-20;
const float kClipped = 0.05;  // weight of a sample that is only a bound
