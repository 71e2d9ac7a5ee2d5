// Scores of one estimated HDR picture against the truth. Both are first normalised: one gain per channel on
// the estimate, then clipped to [0, white] and divided by white, so that 1 is the brightest radiance that
// counts. Reentrant.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/core/image.h"

namespace hdrcam {

// The normalisation of a whole clip.
struct Normalisation {
  double white = 1;  // radiance that becomes 1
  // Estimate to truth, per channel: the response's unobservable scale.
  std::array<double, 3> gain = {1, 1, 1};
};

struct ComparablePair {
  Image<float> truth, estimate;                      // [rgb, rows, cols] 0..1
  Image<float> truth_luminance, estimate_luminance;  // [1, rows, cols] Rec. 709 luminance
  Image<float> truth_log2, estimate_log2;            // [1, rows, cols] log2 luminance, stops, -14..0
};

struct PictureScores {
  double psnr_mu_db = 0;      // after the mu-law (online/mu_law.h)
  double psnr_l_db = 0;       // of linear values
  double psnr_pu_db = 0;      // after PU21 (Mantiuk and Azimi 2021), white shown at 4000 cd/m2
  double ssim_mu = 0;         // structural similarity of mu-law luminance, 11x11 Gaussian of 1.5 px
  double log_rmse_stops = 0;  // of log2 luminance
  double log_bias_stops = 0;  // its mean error: above 0 the estimate is too bright
  std::optional<double> psnr_mu_moving_db;  // psnr_mu of the masked pixels, where there are any
};

// truth, estimate: [rgb, rows, cols] of one size, finite.
ComparablePair comparable_pair(const Image<float>& truth, const Image<float>& estimate,
                               const Normalisation& shared);

// psnr_mu alone, of radiance [rgb, rows, cols] of one size, finite, normalised as above.
double psnr_mu_db(const Image<float>& truth, const Image<float>& estimate, const Normalisation& shared);

// moving: [1, rows, cols] 1 on moving objects, or empty.
PictureScores score_picture(const ComparablePair& pair, const Image<std::uint8_t>& moving);

}  // namespace hdrcam
