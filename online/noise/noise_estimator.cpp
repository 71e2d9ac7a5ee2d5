#include "online/noise/noise_estimator.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "capture/clip_policy.h"
#include "hal/core/robust_spread.h"
#include "online/pictures/local_statistics.h"
#include "online/pictures/sparse_lines.h"

namespace hdrcam {
namespace {

constexpr int kMargin = 3, kStride = 2;  // pixels
constexpr int kStripe = 16;              // rows of those looked at
constexpr int kWholePairs = 8;           // at the beginning
constexpr int kMostTurns = 8;
// Of the shorter exposure, as the longer one predicts it: darker ones are clipped at zero and spread too
// little.
constexpr float kFirstCode = clip_policy::kNoisePair.darkest;
constexpr float kLastCode = clip_policy::kNoisePair.brightest;
constexpr float kDarkest = 1e-4f;   // exposure: what is darker counts to the last bin
constexpr float kSmoothRange = 10;  // codes over 5x5 pixels of the longer exposure

float range_5x5(const Image<float>& image, int channel, int y, int x) {
  float least = std::numeric_limits<float>::max(), most = -least;
  for (int dy = -2; dy <= 2; ++dy) {
    const float* row = image.row(channel, y + dy) + x - 2;
    for (int k = 0; k < 5; ++k) least = std::min(least, row[k]), most = std::max(most, row[k]);
  }
  return most - least;
}

// The share of a picture's noise variance that remains after linear interpolation at this fraction of a
// pixel.
float interpolated_variance(float dx, float dy) {
  const float fx = dx - std::floor(dx), fy = dy - std::floor(dy);
  return (1 - 2 * fx * (1 - fx)) * (1 - 2 * fy * (1 - fy));
}

// Rows [top, bottom] of a picture moved along a flow, and all but the first and last of its means over 3x3
// pixels.
void warp_and_smooth(const Image<float>& codes, const Image<float>& flow, int top, int bottom,
                     Image<float>& warped, Image<float>& mean) {
  const int rows = codes.rows(), cols = codes.cols();
  picture_kernels().warp_linear({.in = codes.plane(0),
                                 .out = warped.plane(0),
                                 .dx = flow.plane(0),
                                 .dy = flow.plane(1),
                                 .channels = codes.channels(),
                                 .rows = rows,
                                 .cols = cols,
                                 .y0 = top,
                                 .y1 = bottom + 1});
  for (int c = 0; c < codes.channels(); ++c)
    for (int y = top + 1; y < bottom; ++y)
      picture_kernels().window(window_at(warped.plane(c), rows, cols, y, 1, mean.row(c, y), nullptr));
}

// The unknowns, as natural logarithms: positive by construction.
enum Parameter { kFullWell, kReadNoise, kCodeNoise, kRelativeNoise, kParameters };
using Parameters = Eigen::Matrix<double, kParameters, 1>;

struct Prior {
  Parameters mean, sigma;
};

// Prior of typical cameras: full wells of 2000 to 15000 electrons within one sigma (at the gain in use), read
// noise of 4 to 9, matches of smooth places good to half a percent or two.
Prior usual_prior(double code_noise) {
  constexpr double kUsualFullWell = 5500, kUsualReadNoise = 6, kUsualMismatch = 0.01, kLeastCodeNoise = 0.05;
  Prior prior;
  prior.mean << std::log(kUsualFullWell), std::log(kUsualReadNoise),
      std::log(std::max(kLeastCodeNoise, code_noise)), std::log(kUsualMismatch);
  prior.sigma << 1.0, 0.4, 0.5, 0.7;
  return prior;
}

// Where single frames told full well and read noise.
Prior prior_around(const NoiseModel& seen) {
  constexpr double kFullWellSigma = 0.15, kReadNoiseSigma = 0.22;
  Prior prior = usual_prior(static_cast<double>(seen.code_noise));
  prior.mean[kFullWell] = std::log(static_cast<double>(seen.full_well));
  prior.mean[kReadNoise] = std::log(static_cast<double>(seen.read_noise));
  prior.sigma[kFullWell] = kFullWellSigma, prior.sigma[kReadNoise] = kReadNoiseSigma;
  return prior;
}

// A step of Gauss-Newton on ln variance, robust against single bins; the prior determines every direction.
// equations: NoiseEstimator::Equation; quantisation: variance in codes^2.
template <class Equations>
Parameters step_from(const Parameters& p, const Prior& prior, const Equations& equations,
                     double quantisation) {
  constexpr double kRobust2 = 4;  // squared scale of the weights, in sigmas
  Eigen::Matrix<double, kParameters, kParameters> A =
      prior.sigma.array().square().inverse().matrix().asDiagonal();
  Parameters b = -((p - prior.mean).array() / prior.sigma.array().square()).matrix();
  const double shot = std::exp(-p[kFullWell]), read = std::exp(2 * (p[kReadNoise] - p[kFullWell]));
  const double code = std::exp(2 * p[kCodeNoise]), relative = std::exp(2 * p[kRelativeNoise]);
  for (const auto& e : equations) {
    const double of_shot = shot * e.factors.shot, of_read = read * e.factors.read;
    const double of_code = code * e.factors.code, of_match = relative * e.factors.relative;
    const double model = of_shot + of_read + of_code + of_match + quantisation * e.factors.code;
    Parameters gradient;  // of ln model
    gradient << -of_shot - 2 * of_read, 2 * of_read, 2 * of_code, 2 * of_match;
    gradient /= model;
    const double residual = std::log(e.variance / model) / e.sigma;
    const double weight = 1 / (e.sigma * e.sigma) / (1 + residual * residual / kRobust2);
    A.noalias() += weight * gradient * gradient.transpose();
    b.noalias() += weight * residual * e.sigma * gradient;
  }
  return A.ldlt().solve(b);
}

template <class Equations>
Parameters most_probable(const Prior& prior, const Equations& equations, double quantisation) {
  constexpr int kIterations = 20;
  constexpr double kMaxStep = 0.7, kConverged = 1e-4;  // in ln
  constexpr double kTiny = 1e-12;                      // keeps the quotient finite
  Parameters p = prior.mean;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Parameters change = step_from(p, prior, equations, quantisation);
    p += change * std::min(1.0, kMaxStep / std::max(kTiny, change.cwiseAbs().maxCoeff()));
    if (change.cwiseAbs().maxCoeff() < kConverged) break;
  }
  return p;
}

}  // namespace

// What is kept of a pixel and channel while its row is compared; planes of one picture.
enum NoiseEstimator::Compared : int {
  kBin,
  kDifference,
  kExposure,
  kSlopeA,
  kSlopeB,
  kLeft,  // of b's noise, after interpolation
  kComparedPlanes
};

void NoiseEstimator::add_pair(const ExposedFrame& a, const ExposedFrame& b, const FlowField& a_to_b,
                              const Response& response, PairGains gains) {
  const int rows = (a.codes.rows() - 2 * kMargin + kStride - 1) / kStride,
            cols = (a.codes.cols() - 2 * kMargin + kStride - 1) / kStride;
  ++pairs_;
  if (rows <= 0 || cols <= 0) return;
  const ScratchLease room(pool_.scratch(), b.codes.rows(), b.codes.cols(),
                          {{&warped_, 3}, {&warped_mean_, 3}});
  const ScratchLease more(pool_.scratch(), rows, 3 * cols, {{&compared_, kComparedPlanes}});
  const float ratio = a.exposure / b.exposure;
  found_.assign(static_cast<std::size_t>(rows), 0);
  compare_stripes(a, b, a_to_b, response, ratio);
  sort_into_bins(ratio, gains);
}

// The first frames are compared everywhere, later ones in a part that is as large as a usual picture, in
// turn, so that no pair of a cycle always has the same.
void NoiseEstimator::compare_stripes(const ExposedFrame& a, const ExposedFrame& b, const FlowField& a_to_b,
                                     const Response& response, float ratio) {
  const auto rows = static_cast<int>(found_.size());
  const auto compare_stripe = [&](int stripe) {
    const int first = stripe * kStripe, last = std::min(first + kStripe, rows) - 1;  // of the rows looked at
    const int top = first * kStride, bottom = last * kStride + 2 * kMargin;          // of the picture
    warp_and_smooth(b.codes, a_to_b.vectors, top, bottom, warped_, warped_mean_);
    for (int row = first; row <= last; ++row)
      found_[static_cast<std::size_t>(row)] = compare_row(a, a_to_b, response, ratio, row);
  };
  // Stripes side by side share rows of the picture, so that each part leaves some out.
  const int stripes = (rows + kStripe - 1) / kStripe;
  const int index = std::max(a.index, b.index);
  const int turns = std::clamp(a.codes.rows() * a.codes.cols() / kUsualPixels, 1, kMostTurns);
  const int parts = std::max(turns, 2);
  for (int part = 0; part < parts; ++part)
    if (turns == 1 || pairs_ <= kWholePairs || part == (index + index / turns) % turns)
      pool_.for_each((stripes - part + parts - 1) / parts, [&](int i) { compare_stripe(i * parts + part); });
}

void NoiseEstimator::sort_into_bins(float ratio, PairGains gains) {
  constexpr float kKeysPerStop = 4;
  const int ratio_key = static_cast<int>(std::lround(-std::log2(ratio) * kKeysPerStop));
  std::array<Bin, kBrightnesses>& bins = bins_[ratio_key];
  for (int row = 0; row < static_cast<int>(found_.size()); ++row)
    for (int i = 0; i < found_[static_cast<std::size_t>(row)]; ++i) {
      const auto of = [&](Compared plane) { return compared_.at(plane, row, i); };
      const float exposure = of(kExposure), left = of(kLeft), slope_a = of(kSlopeA), slope_b = of(kSlopeB);
      bins[static_cast<std::size_t>(of(kBin))].add(
          of(kDifference), {.shot = exposure * (gains.a + left * ratio * gains.b),
                            .read = gains.a * gains.a + left * ratio * ratio * gains.b * gains.b,
                            .code = slope_a * slope_a + left * slope_b * slope_b,
                            .relative = exposure * exposure});
    }
}

// One row of those looked at; how many pixels and channels of it tell of the noise.
int NoiseEstimator::compare_row(const ExposedFrame& a, const FlowField& a_to_b, const Response& response,
                                float ratio, int row) {
  static_assert(
      kDarkest * kDarkest * (1 << kBrightnesses) > 1 && kDarkest * kDarkest * (1 << (kBrightnesses - 1)) <= 1,
      "the darkest exposure lies in the last bin");
  const int y = kMargin + row * kStride;
  int found = 0;
  for (int x = kMargin; x < a.codes.cols() - kMargin; x += kStride) {
    if (a_to_b.confidence.at(0, y, x) < kComparedConfidence) continue;
    const float left = interpolated_variance(a_to_b.vectors.at(0, y, x), a_to_b.vectors.at(1, y, x));
    for (int c = 0; c < 3; ++c) {
      const float za = a.codes.at(c, y, x), zb = warped_.at(c, y, x), mean_b = warped_mean_.at(c, y, x);
      if (za > kLastCode || zb > kLastCode || mean_b < kFirstCode) continue;
      if (range_5x5(warped_mean_, c, y, x) > kSmoothRange) continue;
      const float exposure = response.exposure_of(c, mean_b) * ratio;  // of a, as b predicts it
      const float expected = response.code_of(c, exposure);
      if (expected < kFirstCode || expected > kLastCode) continue;
      const int half_stops = static_cast<int>(std::floor(-2 * std::log2(std::max(kDarkest, exposure))));
      const auto keep = [&](Compared plane, float value) { compared_.at(plane, row, found) = value; };
      keep(kBin, static_cast<float>(std::clamp(half_stops, 0, kBrightnesses - 1)));
      keep(kDifference, response.exposure_of(c, za) - response.exposure_of(c, zb) * ratio);
      keep(kExposure, exposure), keep(kLeft, left);
      keep(kSlopeA, response.slope(c, expected)), keep(kSlopeB, response.slope(c, mean_b) * ratio);
      ++found;
    }
  }
  return found;
}

NoiseEstimator::Equation NoiseEstimator::equation_of(const Bin& bin, std::vector<float>& sorted) {
  constexpr double kModelError = 0.6;  // in ln: bins deviate from the model and are not independent
  constexpr double kNeighbours = 4;    // differences per independent one
  constexpr double kOfSpread = 3;      // variance of ln of a robust_spread() of n normal samples, times n
  constexpr double kLeastVariance = 1e-14;  // of relative exposure: its logarithm stays finite
  sorted.assign(bin.differences.begin(), bin.differences.end());
  const auto n = static_cast<double>(sorted.size());
  Factors<double> sum{};
  for (const Factors<float>& its : bin.factors) {
    sum.shot += static_cast<double>(its.shot), sum.read += static_cast<double>(its.read);
    sum.code += static_cast<double>(its.code), sum.relative += static_cast<double>(its.relative);
  }
  return {{sum.shot / n, sum.read / n, sum.code / n, sum.relative / n},
          std::max(kLeastVariance, robust_spread(sorted).variance),
          std::sqrt(kModelError * kModelError + kOfSpread * kNeighbours / n)};
}

void NoiseEstimator::collect_equations() {
  constexpr std::size_t kMinSamples = 60;
  telling_.clear();
  for (const auto& [ratio, bins] : bins_)
    for (const Bin& bin : bins)
      if (bin.differences.size() >= kMinSamples) telling_.push_back(&bin);
  equations_.resize(telling_.size());
  pool_.for_each(static_cast<int>(kShares), [&](int share) {
    const auto first = static_cast<std::size_t>(share);
    for (std::size_t i = first; i < telling_.size(); i += kShares)
      equations_[i] = equation_of(*telling_[i], sorted_[first]);
  });
}

NoiseModel NoiseEstimator::solve(const NoiseModel& otherwise) {
  constexpr std::size_t kFewestEquations = kParameters;
  collect_equations();
  if (equations_.size() < kFewestEquations) return seen_.value_or(otherwise);
  const double step = static_cast<double>(otherwise.code_step), quantisation = step * step / 12;
  const Prior prior = seen_ ? prior_around(*seen_) : usual_prior(static_cast<double>(otherwise.code_noise));
  const Parameters p = most_probable(prior, equations_, quantisation);
  NoiseModel best = otherwise;
  best.full_well = static_cast<float>(std::exp(p[kFullWell]));
  best.read_noise = static_cast<float>(std::exp(p[kReadNoise]));
  best.code_noise = static_cast<float>(std::exp(p[kCodeNoise]));
  return best;
}

}  // namespace hdrcam
