// The passes of fusion.h on raw pointers, a row of n pixels at a time: one table of functions per instruction
// set, picked at start by fusion_kernels(). Reentrant. Declarations only: the kernels' file may include
// nothing with inline code (CMakeLists.txt).
#pragma once

namespace hdrcam {

// One channel of a frame becomes samples.
struct SampledRow {
  const float *codes, *brightest;
  const float* radiances;  // by code (ExposureTables::radiances())
  float *radiance, *weight, *comparable;
};

// One channel of the state where it knows the pixel, and the motion where it is asked for is believed; the
// sample elsewhere.
struct StandInRow {
  const float *state, *variance, *sample;
  const float* trust;     // confidence of the motion, or null
  float known, believed;  // variance from which on the state does not know the pixel; confidence from which
                          // on it is believed
  float* out;
};

// Variance of a sample by the radiance of its pixel (ExposureTables::variances()).
struct SampleVariances {
  const float* table;
  float exposure;
};

// One channel of state and samples, compared: adds to chi^2 and to the number of comparable channels.
struct ComparedRow {
  const float *state, *variance, *mean, *contrast;
  const float *sample, *comparable, *blur;
  SampleVariances noise;
  float known;                // variance from which on the state does not know the pixel
  float relative2, texture2;  // of radiance squared and of the local contrast: always allowed
  float blur_tolerance;
  float *chi2, *covered;
};

// All channels: how far state and samples show the same surface.
struct GatedRow {
  const float *chi2, *covered, *trust;
  const float *state[3], *sample[3], *weight[3];
  float tolerance, scale, floor;  // of FusionOptions
  float* gate;
};

// One channel of the state, updated by the samples.
struct UpdatedRow {
  const float *state, *variance;
  const float *sample, *weight, *mean, *blur;
  const float *gate, *extra;  // null: 1, 0
  SampleVariances noise;
  float known, relative2, blur_variance, unknown_blur_variance;
  float *new_state, *new_variance;
  float* share;  // a third of this channel's is added
};

// Variance added by a warp along (dx, dy) to one channel.
struct WarpedRow {
  const float *dx, *dy, *contrast;
  float scale;
  float* variance;
};

struct FusionKernels {
  void (*sample)(const SampledRow&, int n);
  void (*stand_in)(const StandInRow&, int n);
  void (*compare)(const ComparedRow&, int n);
  void (*gate)(const GatedRow&, int n);
  void (*update)(const UpdatedRow&, int n);
  void (*warp_variance)(const WarpedRow&, int n);
};

const FusionKernels& fusion_kernels();

}  // namespace hdrcam
