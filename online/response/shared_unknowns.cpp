#include "online/response/shared_unknowns.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "online/response/noise_evidence.h"

namespace hdrcam::shared_unknowns {

Eigen::Index count(const std::vector<int>& keys) {
  return kExposures + static_cast<Eigen::Index>(keys.size());
}

Eigen::Index place_of(int key, const std::vector<int>& keys) {
  return kExposures + (std::lower_bound(keys.begin(), keys.end(), key) - keys.begin());
}

// Nominal times are within a sixth of a stop of the true ones, mostly within a twentieth.
Eigen::MatrixXd prior_precision(const std::vector<int>& keys, Curves curves) {
  constexpr double kSigma = 0.04 * 0.69314718056;  // ln, of .04 stop
  constexpr double kUnbent = 1e6;  // of the direction that bends all to a power: as good as fixed
  const auto n = static_cast<Eigen::Index>(keys.size());
  Eigen::MatrixXd precision = Eigen::MatrixXd::Identity(kExposures + n, kExposures + n) / (kSigma * kSigma);
  precision(kFullWell, kFullWell) = std::pow(SensorNoise::kFullWellSigma, -2);
  precision(kReadNoise, kReadNoise) = std::pow(SensorNoise::kReadNoiseSigma, -2);
  if (curves == Curves::Known) return precision;
  Eigen::VectorXd power(n);
  for (Eigen::Index k = 0; k < n; ++k) power[k] = keys[static_cast<std::size_t>(k)];
  if (n > 0) power.array() -= power.mean();
  if (power.norm() > 0)
    precision.bottomRightCorner(n, n) += kUnbent * power * power.transpose() / power.squaredNorm();
  return precision;
}

}  // namespace hdrcam::shared_unknowns
