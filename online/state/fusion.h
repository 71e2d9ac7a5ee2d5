// How a sample of a pixel is weighed against what is already known of it: saturation, noise, motion blur,
// misalignment and plain disagreement. Shared by the state (each frame's own sample) and by the emission
// (later frames' samples). Constants were settled by ablation on clips with ground truth (docs/decisions.md).
// Thread-bound: owns its buffers.
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
  Image<float> comparable;  // 1 where the code is well inside the range: fit to be compared
};

struct FusionOptions {
  float relative_noise = 0.02f;  // of radiance: what the model does not know
  float blur_weight = 8;         // of the squared blur bias, added to the variance
  float chi2_tolerance = 1.5f;   // mean chi^2 over the window up to which a sample is taken as it is
  float chi2_scale = 1.5f;       // e-folding of the weight above it
  float chi2_relative = 0.04f;   // of radiance: disagreement always allowed
  float chi2_texture = 0.25f;    // of the local contrast: disagreement that misalignment explains
  float gate_floor = 0.002f;     // a sample is never fully rejected: no hole without an answer
  float misalignment = 0.4f;     // of the local contrast: standard deviation of a warped sample
};

class Fusion {
 public:
  Fusion(FusionOptions options, int rows, int cols, WorkerPool& pool);

  const FusionOptions& options() const { return options_; }
  void set_white(float white) { white_ = white; }
  float white() const { return white_; }

  // codes: [rgb, rows, cols]; brightest: the largest code that went into a warped one, or codes itself.
  void sample(const Image<float>& codes, const Image<float>& brightest, const ExposureTables& tables,
              Samples& samples);

  // How far to trust that state and samples show the same thing: [1, rows, cols] 0..1, from agreement over
  // 5x5 pixels, from `confidence` of the motion, and from the bound that a clipped sample gives.
  void gate(const RadianceState& state, const Samples& samples, const ExposureTables& tables,
            const Image<float>& confidence, Image<float>& gate);

  // Inverse-variance update of the state by the samples. flow (pixels per interval) and blur_fraction say how
  // far the samples are blurred; gate and extra_variance (of misalignment, [rgb, rows, cols]) may be null.
  // Where nobody saw the pixel the radiance becomes the larger of the bounds. Returns each pixel's share of
  // this sample in `share`.
  void update(RadianceState& state, const Samples& samples, const ExposureTables& tables,
              const Image<float>& flow, float blur_fraction, const Image<float>* gate,
              const Image<float>* extra_variance, Image<float>& share);

  // Variance that a warp along `flow` adds to a picture of this local contrast: misalignment and
  // interpolation.
  void warp_variance(const Image<float>& contrast, const Image<float>& flow, Image<float>& variance);

 private:
  FusionOptions options_;
  float white_ = 1;
  WorkerPool& pool_;
  Image<float> mean_, contrast_, disagreement_, coverage_, disagreement_mean_, coverage_mean_, bias_, guess_;
};

}  // namespace hdrcam
