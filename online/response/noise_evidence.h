// What the spread of codes by a sensor's own noise says of the response: at a code whose light is x, that
// spread is the noise of x times the slope of the code over the light. Full well and read noise are unknown,
// too; levels over the whole range tell them with the curve, because x is 1 at the last code. Reentrant.
#pragma once

#include <vector>

#include "online/response/curve_squares.h"
#include "online/response/noise_levels.h"

namespace hdrcam {

// Full well and read noise, as factors of usual ones in ln: unknowns of a fit.
struct SensorNoise {
  static constexpr double kUsualFullWell = 5500, kUsualReadNoise = 7;   // electrons
  static constexpr double kFullWellSigma = 1.2, kReadNoiseSigma = 0.6;  // of the prior, ln

  double full_well = 0, read_noise = 0;

  double full_well_electrons() const;
  double read_noise_electrons() const;
};

// Adds the levels of one channel, linear at the curve g and at the noise, to its squares; full_well_at is
// the place of the full well among what the channels share, the read noise follows it. black_level: codes.
void add_noise_evidence(const std::vector<NoiseLevel>& levels, float black_level, const Eigen::VectorXd& g,
                        const SensorNoise& noise, Eigen::Index full_well_at, CurveSquares& squares);

}  // namespace hdrcam
