// The passes of fusion.h on raw pointers, a row of n pixels at a time: one table of functions per instruction
// set, picked at start by fusion_kernels(). `unseen_from` is the variance from which on a pixel counts as
// unseen (radiance_state.h). Reentrant. Declarations only: the kernels' file may include nothing with inline
// code (CMakeLists.txt).
#pragma once

namespace hdrcam {

// One channel of a frame becomes samples.
struct SampledRow {
  const float *codes, *brightest;
  const float* radiances;  // by code (ExposureTables::radiances())
  float *radiance, *weight, *comparable;
};

// All channels of the state as the camera would record them at one exposure: the mean of their codes.
struct RecordedRow {
  const float* radiance[3];
  const float* blur[3];   // what is added to the radiance; null: nothing
  const float* codes[3];  // by kSegments sqrt(relative exposure) (ExposureTables::codes())
  float exposure;
  float* gray;
};

// One channel of the state where it knows the pixel, the sample elsewhere.
struct StandInRow {
  const float *state, *variance, *sample;
  float unseen_from;
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
  const float *sample, *comparable;
  const float* blur;  // null: 0
  SampleVariances noise;
  float unseen_from;
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
  const float *sample, *weight, *mean;
  const float *blur, *gate, *extra;  // null: 0, 1, 0
  SampleVariances noise;
  float unseen_from, relative2, blur_variance, unknown_blur_variance;
  float least;    // radiance that the samples cannot tell from none
  float ringing;  // 0..1: how much codes that fade are doubted where the state is clipped
  bool bounded;   // by a frame exposed no longer, whose clipped pixels these samples do not deny
  bool starts;    // the state holds nothing yet, not even a guess
  float *new_state, *new_variance;
  float* share;  // a third of this channel's is added
};

// One channel: what textures add to the variance of samples that a camera's processing changed by their
// surroundings.
struct TexturedRow {
  const float* mean;       // radiance around the pixel
  SampleVariances hidden;  // the most that is hidden of a texture (ExposureTables::hidden())
  float share;             // of the contrast, however large
  float* doubt;            // the local contrast; becomes the variance
};

// Variance that a warp along (dx, dy) adds, per local contrast.
struct WarpedRow {
  const float *dx, *dy;
  float scale;
  float* per_contrast;
};

// One channel of the state, carried to the pixels of a new frame: how uncertain it has become.
struct AgedRow {
  const float *state, *variance, *gate;
  const float *sample, *weight;          // the new frame's
  const float *contrast, *per_contrast;  // what the warp adds
  float growth, relative2;               // of the variance, and of radiance squared
  float floor;                           // of the gate: up to it the state shows something else
  float unseen_from;
  float lost_variance;  // of a pixel that is lost
  float least;          // radiance that the sample cannot tell from none
  float* new_variance;
};

struct FusionKernels {
  void (*sample)(const SampledRow&, int n);
  void (*record)(const RecordedRow&, int n);
  void (*stand_in)(const StandInRow&, int n);
  void (*compare)(const ComparedRow&, int n);
  void (*gate)(const GatedRow&, int n);
  void (*update)(const UpdatedRow&, int n);
  void (*doubt_textures)(const TexturedRow&, int n);
  void (*warp_variance)(const WarpedRow&, int n);
  void (*age)(const AgedRow&, int n);
};

const FusionKernels& fusion_kernels();

}  // namespace hdrcam
