#include "online/state/fusion.h"

#include <cmath>

#include "capture/clip_policy.h"
#include "hal/core/interpolate.h"
#include "online/pictures/local_statistics.h"
#include "online/state/exposure_blur.h"

namespace hdrcam {
namespace {

constexpr float kTiny = 1e-20f;

}  // namespace

Fusion::Fusion(FusionOptions options, int rows, int cols, WorkerPool& pool) : options_(options), pool_(pool) {
  for (auto* image : {&mean_, &contrast_, &guess_, &shown_}) image->reshape(3, rows, cols);
  for (auto* image : {&disagreement_, &coverage_, &disagreement_mean_, &coverage_mean_})
    image->reshape(1, rows, cols);
}

void Fusion::sample(const Image<float>& codes, const Image<float>& brightest, const ExposureTables& tables,
                    Samples& samples) {
  for (auto* image : {&samples.radiance, &samples.weight, &samples.comparable, &samples.blur})
    image->reshape_like(codes);
  samples.blur.fill(0);
  const int cols = codes.cols();
  pool_.for_rows(codes.rows(), [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c)
      for (int y = y0; y < y1; ++y) {
        const float *z = codes.row(c, y), *top = brightest.row(c, y);
        float *radiance = samples.radiance.row(c, y), *weight = samples.weight.row(c, y);
        float* comparable = samples.comparable.row(c, y);
        for (int x = 0; x < cols; ++x) {
          const float brighter = std::max(z[x], top[x]);
          radiance[x] = tables.radiance(c, z[x]);
          weight[x] = 1 - smooth_step(clip_policy::kFadeBegin, clip_policy::kFadeEnd, brighter);
          comparable[x] =
              (1 - smooth_step(clip_policy::kCompareFadeBegin, clip_policy::kCompareFadeEnd, brighter)) *
              smooth_step(clip_policy::kCompareDarkBegin, clip_policy::kCompareDarkEnd, z[x]);
        }
      }
  });
}

void Fusion::model_blur(const RadianceState& state, const Image<float>& confidence, const Image<float>& flow,
                        float fraction, Samples& samples) {
  constexpr float kBelieved = 0.3f;  // confidence
  const float known = known_limit(white_);
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c)
      for (int y = y0; y < y1; ++y) {
        const float *s = state.radiance.row(c, y), *v = state.variance.row(c, y),
                    *r = samples.radiance.row(c, y), *trust = confidence.row(0, y);
        float* shown = shown_.row(c, y);
        for (int x = 0; x < cols; ++x) shown[x] = trust[x] > kBelieved && v[x] < known ? s[x] : r[x];
      }
  });
  blur_difference(shown_, flow, fraction, samples.blur, pool_);
}

void Fusion::gate(const RadianceState& state, const Samples& samples, const ExposureTables& tables,
                  const Image<float>& confidence, Image<float>& gate) {
  const FusionOptions& o = options_;
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  const float known = known_limit(white_);
  const float relative2 = o.chi2_relative * o.chi2_relative, texture2 = o.chi2_texture * o.chi2_texture;
  local_contrast(state.radiance, mean_, contrast_, pool_);

  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      float *chi2 = disagreement_.row(0, y), *covered = coverage_.row(0, y);
      std::fill_n(chi2, cols, 0.f);
      std::fill_n(covered, cols, 0.f);
      for (int c = 0; c < 3; ++c) {
        const float *s = state.radiance.row(c, y), *v = state.variance.row(c, y);
        const float *r = samples.radiance.row(c, y), *m = samples.comparable.row(c, y);
        const float *mean = mean_.row(c, y), *contrast = contrast_.row(c, y), *blur = samples.blur.row(c, y);
        for (int x = 0; x < cols; ++x) {
          const float mask = v[x] < known ? m[x] : 0;
          const float d = s[x] + blur[x] - r[x], average = 0.5f * (s[x] + r[x]);
          const float allowed = v[x] + tables.variance(c, mean[x]) + relative2 * average * average +
                                texture2 * contrast[x] + o.blur_tolerance * blur[x] * blur[x] + kTiny;
          chi2[x] += mask * d * d / allowed;
          covered[x] += mask;
        }
      }
    }
  });
  box_mean(disagreement_, 2, disagreement_mean_, pool_);
  box_mean(coverage_, 2, coverage_mean_, pool_);

  gate.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float *chi2 = disagreement_mean_.row(0, y), *covered = coverage_mean_.row(0, y);
      const float* trust = confidence.row(0, y);
      float* g = gate.row(0, y);
      for (int x = 0; x < cols; ++x) {
        const float excess = std::max(0.f, chi2[x] / (covered[x] + 0.05f) - o.chi2_tolerance);
        const float agreement =
            1 - std::min(1.f, covered[x]) * (1 - o.gate_floor) * (1 - std::exp(-excess / o.chi2_scale));
        // a clipped sample is a lower bound; a darker state does not show the same surface
        float bound = 1;
        for (int c = 0; c < 3; ++c) {
          if (samples.weight.at(c, y, x) >= 0.05f) continue;
          const float ratio = state.radiance.at(c, y, x) / (0.9f * samples.radiance.at(c, y, x) + kTiny);
          if (ratio < 1) {
            const float below = (1 - ratio) / 0.15f;
            bound = std::min(bound, std::exp(-below * below));
          }
        }
        g[x] = trust[x] * agreement * (o.gate_floor + (1 - o.gate_floor) * bound);
      }
    }
  });
}

void Fusion::update(RadianceState& state, const Samples& samples, const ExposureTables& tables,
                    const Image<float>* gate, const Image<float>* extra_variance, Image<float>& share) {
  const FusionOptions& o = options_;
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  const float known = known_limit(white_);
  const float relative2 = o.relative_noise * o.relative_noise;
  // the radiance that the noise model is asked for: the state where it is known, else the sample; smoothed
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c)
      for (int y = y0; y < y1; ++y) {
        const float *s = state.radiance.row(c, y), *v = state.variance.row(c, y),
                    *r = samples.radiance.row(c, y);
        float* guess = guess_.row(c, y);
        for (int x = 0; x < cols; ++x) guess[x] = v[x] > known ? r[x] : s[x];
      }
  });
  box_mean(guess_, 1, mean_, pool_);

  share.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      float* shared = share.row(0, y);
      std::fill_n(shared, cols, 0.f);
      const float* g = gate != nullptr ? gate->row(0, y) : nullptr;
      for (int c = 0; c < 3; ++c) {
        float *s = state.radiance.row(c, y), *v = state.variance.row(c, y);
        const float *r = samples.radiance.row(c, y), *usable = samples.weight.row(c, y);
        const float *mean = mean_.row(c, y), *blur = samples.blur.row(c, y);
        const float* extra = extra_variance != nullptr ? extra_variance->row(c, y) : nullptr;
        for (int x = 0; x < cols; ++x) {
          float variance = tables.variance(c, mean[x]) + relative2 * mean[x] * mean[x];
          const float blur2 = blur[x] * blur[x];
          float sample = r[x];
          if (v[x] < known) {
            sample = std::max(0.f, sample - blur[x] * blur2 / (blur2 + v[x] + kTiny));
            variance += o.blur_variance * blur2;
          } else {
            variance += o.unknown_blur_variance * blur2;
          }
          if (extra != nullptr) variance += extra[x];
          const float weight = usable[x] * (g != nullptr ? g[x] : 1.f) / (variance + kTiny);
          const float before = 1 / (v[x] + kTiny);
          if (weight > 1e-5f / (mean[x] * mean[x] + kTiny) || v[x] < known) {
            s[x] = (s[x] * before + sample * weight) / (before + weight);
            v[x] = 1 / (before + weight);
            shared[x] += weight / (before + weight) * (1 / 3.f);
          } else {
            s[x] = std::max(r[x], s[x]);
          }
        }
      }
    }
  });
}

void Fusion::warp_variance(const Image<float>& contrast, const Image<float>& flow, Image<float>& variance) {
  const float scale = options_.misalignment * options_.misalignment;
  variance.reshape_like(contrast);
  const int cols = contrast.cols();
  pool_.for_rows(contrast.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float *u = flow.row(0, y), *v = flow.row(1, y);
      for (int x = 0; x < cols; ++x) {
        const float fx = u[x] - std::floor(u[x]), fy = v[x] - std::floor(v[x]);
        const float between = 2 * (fx * (1 - fx) + fy * (1 - fy));
        const float moving = std::min(1.f, std::sqrt(u[x] * u[x] + v[x] * v[x]));
        const float factor = scale * (0.3f * moving + 0.7f * between);
        for (int c = 0; c < contrast.channels(); ++c) variance.at(c, y, x) = factor * contrast.at(c, y, x);
      }
    }
  });
}

}  // namespace hdrcam
