#include "render/scores/picture_scores.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "online/mu_law.h"
#include "render/srgb.h"

namespace hdrcam {
namespace {

constexpr float kDarkest = 1.0f / 16384;  // 14 stops below white
constexpr float kPuWhite_nits = 4000;

float mu_law(float x) { return std::log1p(kPsnrMu * x) / std::log(kPsnrMu + 1); }

// PU21, "banding + glare" (Mantiuk and Azimi 2021): luminance to perceptually uniform units.
float pu21(float luminance_nits) {
  constexpr float kLeast_nits = 0.005f, kMost_nits = 10000;  // for which it is fitted
  constexpr float kP[7] = {0.353487901f,   0.3734658629f, 8.277049286e-05f, 0.9062562627f,
                           0.09150303166f, 0.9099517204f, 596.3148142f};
  const float y = std::pow(std::clamp(luminance_nits, kLeast_nits, kMost_nits), kP[3]);
  return kP[6] * (std::pow((kP[0] + kP[1] * y) / (1 + kP[2] * y), kP[4]) - kP[5]);
}

// Equal pictures have 120 dB.
double decibel(double mean_square) { return -10 * std::log10(std::max(mean_square, 1e-12)); }

double square(double v) { return v * v; }

// Structural similarity (Wang et al. 2004, eq. 13), of pictures whose range is 1.
double structural_similarity(const cv::Mat& a, const cv::Mat& b) {
  constexpr double kC1 = 1e-4, kC2 = 9e-4;  // (K L)^2 with K1 = 0.01, K2 = 0.03
  constexpr int kWindow_px = 11;
  constexpr double kSigma_px = 1.5;
  const auto blurred = [](const cv::Mat& m) {
    cv::Mat out;
    cv::GaussianBlur(m, out, cv::Size(kWindow_px, kWindow_px), kSigma_px);
    return out;
  };
  const cv::Mat mean_a = blurred(a), mean_b = blurred(b);
  const cv::Mat square_a = blurred(a.mul(a)), square_b = blurred(b.mul(b)), product = blurred(a.mul(b));
  double sum = 0;
  for (int i = 0; i < static_cast<int>(a.total()); ++i) {
    const double ma = mean_a.at<double>(i), mb = mean_b.at<double>(i);
    const double variance_a = square_a.at<double>(i) - ma * ma, variance_b = square_b.at<double>(i) - mb * mb;
    const double covariance = product.at<double>(i) - ma * mb;
    sum += (2 * ma * mb + kC1) * (2 * covariance + kC2) /
           ((ma * ma + mb * mb + kC1) * (variance_a + variance_b + kC2));
  }
  return sum / static_cast<double>(a.total());
}

cv::Mat mu_law_of(const Image<float>& luminance) {
  cv::Mat m(luminance.rows(), luminance.cols(), CV_64F);
  std::transform(luminance.samples().begin(), luminance.samples().end(), m.begin<double>(),
                 [](float v) { return static_cast<double>(mu_law(v)); });
  return m;
}

Image<float> normalised(const Image<float>& radiance, const std::array<double, 3>& gain, double white) {
  Image<float> out;
  out.reshape_like(radiance);
  const float top = static_cast<float>(white);
  for (int c = 0; c < 3; ++c) {
    const float g = static_cast<float>(gain[static_cast<std::size_t>(c)]);
    std::transform(radiance.plane(c), radiance.plane(c) + radiance.plane_size(), out.plane(c),
                   [=](float v) { return std::clamp(g * v, 0.0f, top) / top; });
  }
  return out;
}

Image<float> luminance_of(const Image<float>& rgb) {
  Image<float> out(1, rgb.rows(), rgb.cols());
  const float *r = rgb.plane(0), *g = rgb.plane(1), *b = rgb.plane(2);
  float* y = out.plane(0);
  for (std::size_t i = 0; i < out.size(); ++i) y[i] = luminance(r[i], g[i], b[i]);
  return out;
}

Image<float> log2_of(const Image<float>& luminance) {
  Image<float> out;
  out.reshape_like(luminance);
  std::transform(luminance.samples().begin(), luminance.samples().end(), out.samples().begin(),
                 [](float v) { return std::log2(std::max(v, kDarkest)); });
  return out;
}

}  // namespace

ComparablePair comparable_pair(const Image<float>& truth, const Image<float>& estimate,
                               const Normalisation& shared) {
  HDRCAM_CHECK(truth.channels() == 3 && truth.same_shape(estimate));
  ComparablePair pair;
  pair.truth = normalised(truth, {1, 1, 1}, shared.white);
  pair.estimate = normalised(estimate, shared.gain, shared.white);
  pair.truth_luminance = luminance_of(pair.truth), pair.estimate_luminance = luminance_of(pair.estimate);
  pair.truth_log2 = log2_of(pair.truth_luminance), pair.estimate_log2 = log2_of(pair.estimate_luminance);
  return pair;
}

double psnr_mu_db(const Image<float>& truth, const Image<float>& estimate, const Normalisation& shared) {
  const Image<float> t = normalised(truth, {1, 1, 1}, shared.white);
  const Image<float> e = normalised(estimate, shared.gain, shared.white);
  double sum = 0;
  for (std::size_t i = 0; i < t.size(); ++i)
    sum += square(static_cast<double>(mu_law(t.samples()[i]) - mu_law(e.samples()[i])));
  return decibel(sum / static_cast<double>(t.size()));
}

PictureScores score_picture(const ComparablePair& pair, const Image<std::uint8_t>& moving) {
  const auto truth = pair.truth.samples(), estimate = pair.estimate.samples();
  const std::size_t pixels = pair.truth.plane_size();
  const double samples = static_cast<double>(truth.size());
  const float pu_white = pu21(kPuWhite_nits);
  double mu = 0, linear = 0, pu = 0, mu_moving = 0;
  std::size_t moving_samples = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const float t = truth[i], e = estimate[i];
    const double mu_error = square(static_cast<double>(mu_law(t) - mu_law(e)));
    mu += mu_error;
    linear += square(static_cast<double>(t - e));
    pu += square(static_cast<double>((pu21(t * kPuWhite_nits) - pu21(e * kPuWhite_nits)) / pu_white));
    if (!moving.empty() && moving.plane(0)[i % pixels] != 0) mu_moving += mu_error, ++moving_samples;
  }

  double log_square = 0, log_sum = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const double difference =
        static_cast<double>(pair.estimate_log2.plane(0)[i] - pair.truth_log2.plane(0)[i]);
    log_square += square(difference), log_sum += difference;
  }

  PictureScores scores;
  scores.psnr_mu_db = decibel(mu / samples);
  scores.psnr_l_db = decibel(linear / samples);
  scores.psnr_pu_db = decibel(pu / samples);
  scores.ssim_mu = structural_similarity(mu_law_of(pair.truth_luminance), mu_law_of(pair.estimate_luminance));
  scores.log_rmse_stops = std::sqrt(log_square / static_cast<double>(pixels));
  scores.log_bias_stops = log_sum / static_cast<double>(pixels);
  if (moving_samples > 0) scores.psnr_mu_moving_db = decibel(mu_moving / static_cast<double>(moving_samples));
  return scores;
}

}  // namespace hdrcam
