#include "online/response/curve_prior.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "online/response/curve_squares.h"

namespace hdrcam {
namespace {

#include "online/response/dorf_prior.inc"

CurvePrior made() {
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;
  constexpr double kFreeSigma = 0.06;   // ln x
  constexpr double kFreeWidth = 0.5;    // in ln (z + kToe)
  constexpr double kToe = 5;            // codes: near black neighbours bend together
  constexpr double kCodeSigma = 0.004;  // ln x
  CurvePrior prior{Vector::Zero(kKnots), {}};
  Matrix covariance = Matrix::Zero(kKnots, kKnots);
  for (int i = 0; i < kKnots; ++i) prior.mean[i] = static_cast<double>(kDorfMean[i]);
  for (const auto& direction : kDorfDirection) {
    Vector d(kKnots);
    for (int i = 0; i < kKnots; ++i) d[i] = static_cast<double>(direction[i]);
    covariance.noalias() += d * d.transpose();
  }
  for (int i = 0; i < kKnots; ++i) {
    for (int j = 0; j < kKnots; ++j) {
      const double d = (std::log(i + 1 + kToe) - std::log(j + 1 + kToe)) / kFreeWidth;
      covariance(i, j) += kFreeSigma * kFreeSigma * std::exp(-d * d / 2);
    }
    covariance(i, i) += kCodeSigma * kCodeSigma;
  }
  prior.precision = covariance.llt().solve(Matrix::Identity(kKnots, kKnots));
  return prior;
}

}  // namespace

const CurvePrior& curve_prior() {
  static const CurvePrior kPrior = made();
  return kPrior;
}

double expected_white(const Eigen::VectorXd& g, int code) {
  const auto& [mean, precision] = curve_prior();
  const Eigen::Index beyond = kKnots - code;
  const Eigen::VectorXd pull = precision.bottomLeftCorner(beyond, code) * (g - mean).head(code);
  const Eigen::VectorXd above = precision.bottomRightCorner(beyond, beyond).llt().solve(pull);
  return mean[kKnots - 1] - above[beyond - 1];
}

}  // namespace hdrcam
