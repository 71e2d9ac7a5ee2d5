#include "online/state/fusion.h"

#include <algorithm>

#include "hal/core/mirrored.h"
#include "online/pictures/local_statistics.h"
#include "online/state/exposure_blur.h"
#include "online/state/fusion_kernels.h"

namespace hdrcam {
namespace {

SampleVariances noise_of(const ExposureTables& tables, int channel) {
  return {tables.variances(channel).data(), tables.exposure()};
}

// The radiance that the noise model is asked for: the state where it is known, else the sample. Of each
// channel a band keeps the three lines that a mean needs. Reentrant for several bands.
class GuessedLines {
 public:
  // lines: [9, bands, cols]
  GuessedLines(const Seen& seen, Image<float>& lines) : seen_(seen), lines_(lines) {}

  // Guesses those lines around row y that the band does not have yet; its rows come one after the other.
  void advance(int band, int y) const {
    for (int next = y % WorkerPool::kBandRows == 0 ? std::max(0, y - 1) : y + 1;
         next <= std::min(y + 1, rows() - 1); ++next)
      for (int c = 0; c < 3; ++c)
        fusion_kernels().stand_in({.state = seen_.state.radiance.row(c, next),
                                   .variance = seen_.state.variance.row(c, next),
                                   .sample = seen_.samples.radiance.row(c, next),
                                   .unseen_from = seen_.unseen_variance,
                                   .out = line(band, c, next)},
                                  seen_.state.radiance.cols());
  }
  // For the statistics of row y; variance: null for the mean alone.
  WindowRow around(int band, int c, int y, float* mean, float* variance) const {
    WindowRow window{
        .line = {}, .cols = seen_.state.radiance.cols(), .radius = 1, .mean = mean, .variance = variance};
    for (int k = 0; k < 3; ++k) window.line[k] = line(band, c, mirrored(y + k - 1, rows()));
    return window;
  }

 private:
  int rows() const { return seen_.state.radiance.rows(); }
  float* line(int band, int c, int y) const { return lines_.row(3 * c + y % 3, band); }

  const Seen& seen_;
  Image<float>& lines_;
};

// The variance of a row's samples beyond their noise; null: none. mean: of the guess. doubt: its local
// contrast where textures are in error, and becomes the variance. misaligned: by warp_variance(), where
// samples were moved.
const float* beyond_noise(const ExposureTables& tables, const Moved* moved, const float* misaligned,
                          int channel, int y, int cols, const float* mean, float* doubt) {
  const bool textured = tables.doubts_textures();
  if (textured)
    fusion_kernels().doubt_textures({.mean = mean,
                                     .hidden = {tables.hidden(channel).data(), tables.exposure()},
                                     .share = tables.texture_error(),
                                     .doubt = doubt},
                                    cols);
  if (moved != nullptr) {
    const float* contrast = moved->contrast.row(channel, y);
    if (textured)
      for (int x = 0; x < cols; ++x) doubt[x] += misaligned[x] * contrast[x];
    else
      for (int x = 0; x < cols; ++x) doubt[x] = misaligned[x] * contrast[x];
  }
  return textured || moved != nullptr ? doubt : nullptr;
}

}  // namespace

void Fusion::sample(const Image<float>& codes, const Image<float>& brightest, const ExposureTables& tables,
                    Samples& samples) {
  for (auto* image : {&samples.radiance, &samples.weight, &samples.comparable, &samples.blur})
    image->reshape_like(codes);
  samples.blurred = false;
  pool_.for_rows(codes.rows(), [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c)
      for (int y = y0; y < y1; ++y)
        fusion_kernels().sample({.codes = codes.row(c, y),
                                 .brightest = brightest.row(c, y),
                                 .radiances = tables.radiances(c).data(),
                                 .radiance = samples.radiance.row(c, y),
                                 .weight = samples.weight.row(c, y),
                                 .comparable = samples.comparable.row(c, y)},
                                codes.cols());
  });
}

void Fusion::model_blur(const RadianceEstimate& state, const Image<float>& flow, float fraction,
                        Samples& samples) {
  samples.blurred = exposure_blurs(flow, fraction, pool_);
  if (samples.blurred) blur_difference(state.radiance, flow, fraction, samples.blur, pool_);
}

void Fusion::gate(const Seen& seen, const Image<float>& confidence, Image<float>& gate,
                  Image<float>& contrast) {
  const int rows = seen.state.radiance.rows(), cols = seen.state.radiance.cols();
  const ScratchLease room(pool_.scratch(), rows, cols, {{&disagreement_, 1}, {&coverage_, 1}});
  const ScratchLease lines(
      pool_.scratch(), WorkerPool::bands_of(rows), cols,
      {{&mean_, 1}, {&disagreement_mean_, 1}, {&coverage_mean_, 1}});  // one for each band
  compare(seen, contrast);
  gate_by_comparison(seen, confidence, gate);
}

void Fusion::compare(const Seen& seen, Image<float>& contrast) {
  const RadianceEstimate& state = seen.state;
  const Samples& samples = seen.samples;
  const FusionOptions& o = options_;
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  const float relative2 = o.chi2_relative * o.chi2_relative, texture2 = o.chi2_texture * o.chi2_texture;
  contrast.reshape_like(state.radiance);
  pool_.for_rows_of_bands(rows, [&](int band, int y) {
    float *chi2 = disagreement_.row(0, y), *covered = coverage_.row(0, y), *mean = mean_.row(0, band);
    std::fill_n(chi2, cols, 0.f);
    std::fill_n(covered, cols, 0.f);
    for (int c = 0; c < 3; ++c) {
      picture_kernels().window(
          window_at(state.radiance.plane(c), rows, cols, y, 1, mean, contrast.row(c, y)));
      fusion_kernels().compare({.state = state.radiance.row(c, y),
                                .variance = state.variance.row(c, y),
                                .mean = mean,
                                .contrast = contrast.row(c, y),
                                .sample = samples.radiance.row(c, y),
                                .comparable = samples.comparable.row(c, y),
                                .blur = samples.blur_row(c, y),
                                .noise = noise_of(seen.tables, c),
                                .unseen_from = seen.unseen_variance,
                                .relative2 = relative2,
                                .texture2 = texture2,
                                .blur_tolerance = o.blur_tolerance,
                                .chi2 = chi2,
                                .covered = covered},
                               cols);
    }
  });
}

void Fusion::gate_by_comparison(const Seen& seen, const Image<float>& confidence, Image<float>& gate) {
  const RadianceEstimate& state = seen.state;
  const Samples& samples = seen.samples;
  const FusionOptions& o = options_;
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  gate.reshape(1, rows, cols);
  pool_.for_rows_of_bands(rows, [&](int band, int y) {
    float *chi2 = disagreement_mean_.row(0, band), *covered = coverage_mean_.row(0, band);
    picture_kernels().window(window_at(disagreement_.plane(0), rows, cols, y, 2, chi2, nullptr));
    picture_kernels().window(window_at(coverage_.plane(0), rows, cols, y, 2, covered, nullptr));
    GatedRow row{.chi2 = chi2,
                 .covered = covered,
                 .trust = confidence.row(0, y),
                 .state = {},
                 .sample = {},
                 .weight = {},
                 .tolerance = o.chi2_tolerance,
                 .scale = o.chi2_scale,
                 .floor = o.gate_floor,
                 .gate = gate.row(0, y)};
    for (int c = 0; c < 3; ++c) {
      row.state[c] = state.radiance.row(c, y);
      row.sample[c] = samples.radiance.row(c, y), row.weight[c] = samples.weight.row(c, y);
    }
    fusion_kernels().gate(row, cols);
  });
}

void Fusion::update(const Seen& seen, const Image<float>* gate, const Moved* moved, RadianceEstimate& after,
                    Image<float>& share, SampleOrder order) {
  const RadianceEstimate& before = seen.state;
  const Samples& samples = seen.samples;
  HDRCAM_CHECK(&before != &after);  // a row's neighbours are read until all of them are written
  const FusionOptions& o = options_;
  const int rows = before.radiance.rows(), cols = before.radiance.cols();
  const float relative2 = o.relative_noise * o.relative_noise;
  const ScratchLease lines(pool_.scratch(), WorkerPool::bands_of(rows), cols,
                           {{&mean_, 1}, {&doubt_, 1}, {&misaligned_, 1}, {&guess_, 9}});
  const bool textured = seen.tables.doubts_textures();
  after.radiance.reshape_like(before.radiance);
  after.variance.reshape_like(before.variance);
  share.reshape(1, rows, cols);

  const GuessedLines guess(seen, guess_);
  pool_.for_rows_of_bands(rows, [&](int band, int y) {
    guess.advance(band, y);
    std::fill_n(share.row(0, y), cols, 0.f);
    float *mean = mean_.row(0, band), *doubt = doubt_.row(0, band), *misaligned = misaligned_.row(0, band);
    if (moved != nullptr) warp_variance(moved->flow, y, misaligned, moved->intervals);
    for (int c = 0; c < 3; ++c) {
      picture_kernels().window(guess.around(band, c, y, mean, textured ? doubt : nullptr));
      const float* extra = beyond_noise(seen.tables, moved, misaligned, c, y, cols, mean, doubt);
      fusion_kernels().update({.state = before.radiance.row(c, y),
                               .variance = before.variance.row(c, y),
                               .sample = samples.radiance.row(c, y),
                               .weight = samples.weight.row(c, y),
                               .mean = mean,
                               .blur = samples.blur_row(c, y),
                               .gate = gate != nullptr ? gate->row(0, y) : nullptr,
                               .extra = extra,
                               .noise = noise_of(seen.tables, c),
                               .unseen_from = seen.unseen_variance,
                               .relative2 = relative2,
                               .blur_variance = o.blur_variance,
                               .unknown_blur_variance = o.unknown_blur_variance,
                               .least = seen.tables.least_radiance(c),
                               .ringing = seen.tables.ringing(),
                               .bounded = moved != nullptr && !moved->shorter,
                               .starts = order == SampleOrder::FirstFrame,
                               .new_state = after.radiance.row(c, y),
                               .new_variance = after.variance.row(c, y),
                               .share = share.row(0, y)},
                              cols);
    }
  });
}

void Fusion::warp_variance(const Image<float>& flow, int y, float* per_contrast, int intervals) const {
  const float scale = static_cast<float>(intervals) * options_.misalignment * options_.misalignment;
  fusion_kernels().warp_variance({flow.row(0, y), flow.row(1, y), scale, per_contrast}, flow.cols());
}

}  // namespace hdrcam
