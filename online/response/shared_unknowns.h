// What the curves of all channels share and what is fitted with them: the noise of the sensor, and what
// stated exposures are off. One vector e: full well, read noise (as SensorNoise has them: ln of the factor of
// usual ones), then ln of true over stated exposure for each exposure. Reentrant.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace hdrcam::shared_unknowns {

inline constexpr Eigen::Index kFullWell = 0, kReadNoise = 1, kExposures = 2;  // places in e

// keys: of the exposures, ascending (ExposureCorrections::key).
Eigen::Index count(const std::vector<int>& keys);
// Where e has the exposure of this key, which is one of them.
Eigen::Index place_of(int key, const std::vector<int>& keys);
// Values of e, and the keys of the exposures that it has.
struct Values {
  const std::vector<int>& keys;
  const Eigen::VectorXd& e;
};
// Whether the curves are fitted, too. All exposures to a power, and the curve to the same, explain the same
// matches: which power it is only real cameras tell, so exposures are not bent that way, unless the curve is
// known.
enum class Curves { Fitted, Known };
// The inverse covariance of its prior, whose mean is 0: [count, count].
Eigen::MatrixXd prior_precision(const std::vector<int>& keys, Curves curves);

}  // namespace hdrcam::shared_unknowns
