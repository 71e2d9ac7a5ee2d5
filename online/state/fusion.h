// Weighs a sample of a pixel against the state: saturation, noise, motion blur, misalignment and
// disagreement. Shared by the state (each frame's own sample) and by the look-ahead (later frames' samples).
// Constants were settled by ablation on clips with ground truth (docs/decisions/state.md). Thread-bound;
// borrows from its pool.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "online/pictures/flow_field.h"
#include "online/state/exposure_tables.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

// One frame's samples, possibly warped to another frame's pixels.
struct Samples {
  Image<float> radiance;    // [rgb, rows, cols]
  Image<float> weight;      // 1 where the code is far from saturation, 0 where saturated
  Image<float> comparable;  // 1 where the code is well inside the range: usable for comparisons
  Image<float> blur;        // change of the radiance by motion blur, as the state predicts it; else undefined
  bool blurred = false;

  const float* blur_row(int channel, int y) const { return blurred ? blur.row(channel, y) : nullptr; }
};

// Samples in memory that is acquired for as long as this lives, for codes of this size.
class SamplesLease {
 public:
  SamplesLease(ScratchPictures& scratch, const Image<float>& codes, Samples& samples)
      : room_(scratch, codes.rows(), codes.cols(),
              {{&samples.radiance, 3}, {&samples.weight, 3}, {&samples.comparable, 3}, {&samples.blur, 3}}) {}

 private:
  const ScratchLease room_;
};

// A state and samples at its pixels.
struct Seen {
  const RadianceEstimate& state;
  const Samples& samples;
  const ExposureTables& tables;  // at the samples' exposure
  float unseen_variance;         // from which on a pixel of the state counts as unseen
};

// Samples that were moved, for the variance that this adds: the local contrast at the pixels that they were
// moved to [rgb, rows, cols], and the flow along which they were read, over as many intervals.
struct Moved {
  const Image<float>& contrast;
  const Image<float>& flow;
  int intervals = 1;
  bool shorter = false;  // exposed than the frame that they were moved to
};

// Before the first frame the state holds nothing; after it, at least a guess of what it does not know.
enum class SampleOrder { FirstFrame, AfterFirst };

struct FusionOptions {
  float relative_noise = 0.005f;    // of radiance: error outside the model
  float blur_variance = 1;          // of the squared blur that the state predicts, added to the sample's
  float unknown_blur_variance = 8;  // the same where the state does not know the pixel
  float blur_tolerance = 0.1f;      // of the squared blur: disagreement that the gate allows for it
  float chi2_tolerance = 1.5f;      // mean chi^2 over the window up to which a sample is taken as it is
  float chi2_scale = 1.5f;          // e-folding of the weight above it
  float chi2_relative = 0.04f;      // of radiance: disagreement always allowed
  float chi2_texture = 0.25f;       // of the local contrast: disagreement that misalignment explains
  float gate_floor = 0.002f;        // a sample is never fully rejected, so that no pixel is left empty
  float misalignment = 0.4f;        // of the local contrast: standard deviation of a warped sample
};

class Fusion {
 public:
  Fusion(FusionOptions options, WorkerPool& pool) : options_(options), pool_(pool) {}

  // Without blur, until model_blur(). codes: [rgb, rows, cols]; brightest: the largest code around the place
  // of a warped one, or codes itself.
  void sample(const Image<float>& codes, const Image<float>& brightest, const ExposureTables& tables,
              Samples& samples);

  // Fills samples.blur where the exposure blurs anything: the change of the state's picture by its motion at
  // these pixels, so that a long exposure is compared with the blurred state and corrected by the difference.
  // flow: pixels per interval; fraction: of the interval that the exposure lasts.
  void model_blur(const RadianceEstimate& state, const Image<float>& flow, float fraction, Samples& samples);

  // The confidence that state and samples show the same surface: [1, rows, cols] 0..1, from agreement over
  // 5x5 pixels, from `confidence` of the motion, and from the bound that a clipped sample gives. contrast:
  // becomes the local contrast of the state, [rgb, rows, cols].
  void gate(const Seen& seen, const Image<float>& confidence, Image<float>& gate, Image<float>& contrast);

  // Inverse-variance update of the state by the samples, after subtracting the blur as far as the state is
  // certain of it; gate, and what was moved to these pixels, may be null. Where no frame saw the pixel
  // unclipped, the radiance becomes the larger of the bounds. Writes `after`, another estimate than the
  // state, and each pixel's share of this sample into `share`.
  void update(const Seen& seen, const Image<float>* gate, const Moved* moved, RadianceEstimate& after,
              Image<float>& share, SampleOrder order = SampleOrder::AfterFirst);

  // Variance that reading along the flow adds to row y, per local contrast: misalignment and interpolation,
  // both of each interval that it is chained of.
  void warp_variance(const Image<float>& flow, int y, float* per_contrast, int intervals = 1) const;

 private:
  // The steps of gate(). The first writes chi^2 and how many channels gave it, [1, rows, cols], and the
  // contrast; the second weighs their means over 5x5 pixels.
  void compare(const Seen& seen, Image<float>& contrast);
  void gate_by_comparison(const Seen& seen, const Image<float>& confidence, Image<float>& gate);

  FusionOptions options_;
  WorkerPool& pool_;
  // All are borrowed during a call.
  Image<float> disagreement_, coverage_;
  // lines, one or more for each band
  Image<float> mean_, disagreement_mean_, coverage_mean_, guess_, doubt_, misaligned_;
};

}  // namespace hdrcam
