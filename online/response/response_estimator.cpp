#include "online/response/response_estimator.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace hdrcam {
namespace {

#include "online/response/dorf_prior.inc"

constexpr int kKnots = 255;     // g(z) at the codes 1..255
constexpr int kGaugeKnot = 127; // where g is pinned: a common factor of x is not observable
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

// Gaussian prior of g: real cameras (mean and principal directions), a smooth free part for cameras unlike them, and a
// small independent part per code.
struct Prior {
  Vector mean = Vector::Zero(kKnots);
  Matrix precision;

  Prior() {
    constexpr double kFreeSigma = 0.06;   // ln x
    constexpr double kFreeWidth = 0.5;    // in ln z
    constexpr double kCodeSigma = 0.004;  // ln x
    Matrix covariance = Matrix::Zero(kKnots, kKnots);
    for (int i = 0; i < kKnots; ++i) mean[i] = static_cast<double>(kDorfMean[i]);
    for (const auto& direction : kDorfDirection) {
      Vector d(kKnots);
      for (int i = 0; i < kKnots; ++i) d[i] = static_cast<double>(direction[i]);
      covariance.noalias() += d * d.transpose();
    }
    for (int i = 0; i < kKnots; ++i) {
      for (int j = 0; j < kKnots; ++j) {
        const double d = (std::log(i + 6.0) - std::log(j + 6.0)) / kFreeWidth;
        covariance(i, j) += kFreeSigma * kFreeSigma * std::exp(-d * d / 2);
      }
      covariance(i, i) += kCodeSigma * kCodeSigma;
    }
    precision = covariance.llt().solve(Matrix::Identity(kKnots, kKnots));
  }
};

const Prior& prior() {
  static const Prior kPrior;
  return kPrior;
}

// A code between two knots of g, codes 1..255.
struct Knots {
  int lo;
  double fraction;
  explicit Knots(float code) {
    const double position = std::clamp(static_cast<double>(code) - 1, 0.0, kKnots - 1.0);
    lo = std::min(static_cast<int>(position), kKnots - 2);
    fraction = position - lo;
  }
  double of(const Vector& g) const { return g[lo] + fraction * (g[lo + 1] - g[lo]); }
  double slope(const Vector& g) const {  // per code, over three codes
    const int z = fraction < 0.5 ? lo : lo + 1, a = std::max(0, z - 1), b = std::min(kKnots - 1, z + 1);
    return (g[b] - g[a]) / (b - a);
  }
};

std::array<Response::Curve, 3> curves_of(const std::array<Vector, 3>& g) {
  std::array<Response::Curve, 3> inverse;
  for (std::size_t c = 0; c < 3; ++c) {
    for (int z = 0; z < kKnots; ++z)
      inverse[c][static_cast<std::size_t>(z) + 1] = static_cast<float>(std::exp(g[c][z] - g[c][kKnots - 1]));
    inverse[c][0] = 0.5f * inverse[c][1];
  }
  return inverse;
}

// Means of the codes over a coarse grid, the brightest channel clipped cells marked by -1: what two pictures of one
// scene must have in common up to a monotone curve.
std::vector<float> thumbnail(const ExposedFrame& frame) {
  constexpr int kCells = 16;
  std::vector<float> cells;
  const auto& codes = frame.codes;
  for (int gy = 0; gy < kCells; ++gy)
    for (int gx = 0; gx < kCells; ++gx) {
      const int y0 = codes.rows() * gy / kCells, y1 = std::max(y0 + 1, codes.rows() * (gy + 1) / kCells);
      const int x0 = codes.cols() * gx / kCells, x1 = std::max(x0 + 1, codes.cols() * (gx + 1) / kCells);
      double sum = 0;
      for (int y = y0; y < std::min(y1, codes.rows()); ++y)
        for (int x = x0; x < std::min(x1, codes.cols()); ++x) sum += static_cast<double>(codes.at(1, y, x));
      const auto mean = static_cast<float>(sum / ((y1 - y0) * (x1 - x0)));
      cells.push_back(mean < 3 || mean > 250 ? -1 : mean);
    }
  return cells;
}

// Spearman's rank correlation over the cells that neither picture clipped; 1 when too few are left to tell.
double rank_correlation(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<std::size_t> both;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] >= 0 && b[i] >= 0) both.push_back(i);
  if (both.size() < 24) return 1;
  const auto ranks = [&](const std::vector<float>& v) {
    std::vector<std::size_t> order(both.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](auto i, auto j) { return v[both[i]] < v[both[j]]; });
    std::vector<double> rank(both.size());
    for (std::size_t r = 0; r < order.size(); ++r) rank[order[r]] = static_cast<double>(r);
    return rank;
  };
  const auto ra = ranks(a), rb = ranks(b);
  const double n = static_cast<double>(both.size());
  double square = 0;
  for (std::size_t i = 0; i < ra.size(); ++i) square += (ra[i] - rb[i]) * (ra[i] - rb[i]);
  return 1 - 6 * square / (n * (n * n - 1));
}

}  // namespace

bool ResponseEstimator::add_pair(const ExposedFrame& a, const ExposedFrame& b) {
  constexpr double kMinRatio = 1.15;       // of exposures: below it a pair says nothing about the curve
  constexpr double kSameSceneRank = 0.35;  // a cut is near 0; a fast pan of a textured scene stays above .6
  const ExposedFrame& shorter = a.exposure <= b.exposure ? a : b;
  const ExposedFrame& longer = &shorter == &a ? b : a;
  if (longer.exposure < static_cast<float>(kMinRatio) * shorter.exposure) return false;
  if (((a.facts.flags | b.facts.flags) & (kFrameExposureUnproved | kFrameDamaged)) != 0) return false;
  if (rank_correlation(thumbnail(a), thumbnail(b)) < kSameSceneRank) return false;

  const auto steps = [](float exposure) { return static_cast<int>(std::lround(std::log2(exposure) * 64)); };
  const std::pair key{steps(shorter.exposure), steps(longer.exposure)};
  const std::size_t n = a.codes.plane_size();
  std::vector<float> sorted_a(n), sorted_b(n);
  for (int c = 0; c < 3; ++c) {
    std::copy_n(shorter.codes.plane(c), n, sorted_a.begin());
    std::copy_n(longer.codes.plane(c), n, sorted_b.begin());
    std::sort(sorted_a.begin(), sorted_a.end());
    std::sort(sorted_b.begin(), sorted_b.end());
    auto& matches = matches_[static_cast<std::size_t>(c)][key];
    matches.log_ratio = (key.first - key.second) / 64.0 * std::log(2.0);
    for (std::size_t q = 1; q < kQuantiles; ++q) {
      const std::size_t p = n * q / kQuantiles;
      const float z1 = sorted_a[p], z2 = sorted_b[p];
      if (z1 >= 1 && z1 < 253 && z2 >= z1 && z2 < 253) matches.codes.push_back({z1, z2});
    }
  }
  ++pairs_;
  return true;
}

Response ResponseEstimator::solve(const NoiseModel& noise, const Response* start) const {
  constexpr int kIterations = 4;
  constexpr double kMatchSigma = 0.06;         // ln x: motion between the frames moves the quantiles
  constexpr double kCauchy2 = 4;               // squared scale of the robust weight, in sigmas
  constexpr double kMatchWeight = 0.2;         // quantiles are not independent
  constexpr double kMaxWeightPerRatio = 1000;  // matches of one exposure ratio count as at most so many
  const Prior& p = prior();

  std::array<Vector, 3> curves;
  for (std::size_t c = 0; c < 3; ++c) {
    Vector g = p.mean;
    if (start != nullptr)
      for (int z = 0; z < kKnots; ++z)
        g[z] = std::log(std::max(1e-6, static_cast<double>(start->inverse(static_cast<int>(c))[static_cast<std::size_t>(z) + 1])));
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      Matrix A = p.precision;
      Vector b = p.precision * p.mean;
      A(kGaugeKnot, kGaugeKnot) += 1e4;
      const double top = g[250];
      const auto variance = [&](const Knots& k) {
        const double slope = k.slope(g), x = std::exp(k.of(g) - top);
        return slope * slope / 12 + 0.5 * static_cast<double>(noise.exposure_variance(static_cast<float>(x))) / (x * x);
      };
      for (const auto& [key, matches] : matches_[c]) {
        if (matches.codes.empty()) continue;
        const double scale =
            kMatchWeight * std::min(1.0, kMaxWeightPerRatio / static_cast<double>(matches.codes.size()));
        for (const Match& match : matches.codes) {
          const Knots k1(match.z1), k2(match.z2);
          const double r = k1.of(g) - k2.of(g) - matches.log_ratio;
          const double s2 = kMatchSigma * kMatchSigma + variance(k1) + variance(k2);
          const double w = scale / s2 / (1 + r * r / (s2 * kCauchy2));
          // r is linear in four knots: (1-f1, f1) at z1, -(1-f2, f2) at z2
          const std::array<int, 4> at{k1.lo, k1.lo + 1, k2.lo, k2.lo + 1};
          const std::array<double, 4> by{1 - k1.fraction, k1.fraction, k2.fraction - 1, -k2.fraction};
          for (std::size_t i = 0; i < 4; ++i) {
            b[at[i]] += w * matches.log_ratio * by[i];
            for (std::size_t j = 0; j < 4; ++j) A(at[i], at[j]) += w * by[i] * by[j];
          }
        }
      }
      g = A.llt().solve(b);
      for (int z = 1; z < kKnots; ++z) g[z] = std::max(g[z], g[z - 1] + 1e-4);
    }
    curves[c] = g;
  }
  return Response(curves_of(curves));
}

Response prior_mean_response() {
  const Vector& mean = prior().mean;
  return Response(curves_of({mean, mean, mean}));
}

}  // namespace hdrcam
