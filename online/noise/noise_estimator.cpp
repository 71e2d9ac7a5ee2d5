#include "online/noise/noise_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "capture/clip_policy.h"
#include "online/pictures/local_statistics.h"
#include "online/pictures/warp.h"

namespace hdrcam {
namespace {

constexpr int kMargin = 3, kStride = 2;  // pixels
constexpr float kMinConfidence = 0.8f;   // of the flow
constexpr float kSmoothRange = 10;       // codes over 5x5 pixels of the longer exposure

float range_5x5(const Image<float>& image, int channel, int y, int x) {
  float least = std::numeric_limits<float>::max(), most = -least;
  for (int dy = -2; dy <= 2; ++dy) {
    const float* row = image.row(channel, y + dy) + x - 2;
    for (int k = 0; k < 5; ++k) least = std::min(least, row[k]), most = std::max(most, row[k]);
  }
  return most - least;
}

}  // namespace

void NoiseEstimator::Bin::add(float square, float x, float slope2) {
  if (squares.size() < kCapacity)
    squares.push_back(square);
  else
    squares[next] = square, next = (next + 1) % kCapacity;
  count += 1;
  exposure_sum += static_cast<double>(x);
  slope2_sum += static_cast<double>(slope2);
}

void NoiseEstimator::add_pair(const ExposedFrame& a, const ExposedFrame& b, const FlowField& a_to_b,
                              const Response& response) {
  warp_linear(b.codes, a_to_b.vectors, warped_, pool_);
  box_mean(warped_, 1, warped_mean_, pool_);
  box_mean(a.codes, 2, mean_, pool_);
  const clip_policy::UsableCodes usable = clip_policy::kNoisePair;
  const float ratio = a.exposure / b.exposure;
  const int ratio_key = static_cast<int>(std::lround(-std::log2(ratio) * 4));
  std::array<Bin, kBrightnesses>& bins = bins_[ratio_key];
  for (int y = kMargin; y < a.codes.rows() - kMargin; y += kStride)
    for (int x = kMargin; x < a.codes.cols() - kMargin; x += kStride) {
      if (a_to_b.confidence.at(0, y, x) < kMinConfidence) continue;
      for (int c = 0; c < 3; ++c) {
        const float za = a.codes.at(c, y, x), zb = warped_.at(c, y, x);
        if (std::min(za, zb) < usable.darkest || std::max(za, zb) > usable.brightest) continue;
        if (range_5x5(warped_mean_, c, y, x) > kSmoothRange) continue;
        const float mean = mean_.at(c, y, x);
        const float exposure = response.exposure_of(c, mean), slope = response.slope(c, mean);
        const float d = response.exposure_of(c, za) - response.exposure_of(c, zb) * ratio;
        const int half_stops = static_cast<int>(std::floor(-2 * std::log2(std::max(1e-4f, exposure))));
        Bin& bin = bins[static_cast<std::size_t>(std::clamp(half_stops, 0, kBrightnesses - 1))];
        bin.ratio = static_cast<double>(ratio);
        bin.add(d * d, exposure, slope * slope);
      }
    }
}

NoiseModel NoiseEstimator::solve(const NoiseModel& otherwise) {
  constexpr std::size_t kMinSamples = 60;
  constexpr double kMaxWeight = 2000;
  constexpr double kMedianOfChi2 = 0.455;  // of one degree of freedom
  equations_.clear();
  for (const auto& [ratio, bins] : bins_)
    for (const Bin& bin : bins) {
      if (bin.squares.size() < kMinSamples) continue;
      sorted_.assign(bin.squares.begin(), bin.squares.end());
      const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
      std::nth_element(sorted_.begin(), middle, sorted_.end());
      const double x = bin.exposure_sum / bin.count, r = bin.ratio;
      // interpolation between pixels halves the noise of the warped frame
      equations_.push_back({x * (1 + 0.5 * r), 1 + 0.5 * r * r, 1.2 * bin.slope2_sum / bin.count,
                            std::max(1e-14, static_cast<double>(*middle) / kMedianOfChi2),
                            std::min(static_cast<double>(sorted_.size()), kMaxWeight)});
    }
  if (equations_.size() < 4) return otherwise;

  const double step = static_cast<double>(otherwise.code_step);
  NoiseModel best = otherwise;
  double least = std::numeric_limits<double>::max();
  for (const double code_noise : {0., .3, .5, .8, 1.2, 1.6, 2., 2.6, 3.3}) {
    const double code_variance = step * step / 12 + code_noise * code_noise;
    double a11 = 0, a12 = 0, a22 = 0, b1 = 0, b2 = 0;
    for (const Equation& e : equations_) {
      const double y = e.variance - e.slope2 * code_variance, w = e.weight / (e.variance * e.variance);
      a11 += w * e.shot_factor * e.shot_factor, a12 += w * e.shot_factor * e.read_factor;
      a22 += w * e.read_factor * e.read_factor, b1 += w * e.shot_factor * y, b2 += w * e.read_factor * y;
    }
    const double determinant = a11 * a22 - a12 * a12;
    double shot = (b1 * a22 - b2 * a12) / determinant, read = (a11 * b2 - a12 * b1) / determinant;
    if (!(determinant > 0) || read < 0) read = 0, shot = b1 / a11;
    if (shot <= 0) shot = 0, read = std::max(0., b2 / a22);
    shot = std::clamp(shot, 1. / 20000, 1. / 300);
    double misfit = 0;
    for (const Equation& e : equations_) {
      const double model = e.shot_factor * shot + e.read_factor * read + e.slope2 * code_variance;
      const double relative = (e.variance - model) / (e.variance + model);
      misfit += e.weight * relative * relative;
    }
    if (misfit < least) {
      least = misfit;
      best.full_well = static_cast<float>(1 / shot);
      best.read_noise =
          std::clamp(static_cast<float>(std::sqrt(read) / shot), 1.f, std::max(1.f, best.full_well * 0.02f));
    }
  }
  return best;
}

}  // namespace hdrcam
