// What two exposures of one scene say of the response. The same light at the exposures E1 and E2 gives the
// codes z1 and z2, so g(z1) - g(z2) = ln E1/E2, with g = ln x. Each match is one equation, weighted by the
// noise of both codes and robustly (Cauchy). Reentrant.
#pragma once

#include <Eigen/Core>

#include "capture/noise_model.h"
#include "online/response/curve_squares.h"
#include "online/response/histogram_matches.h"
#include "online/response/shared_unknowns.h"

namespace hdrcam {

struct MatchNoise {
  NoiseModel model;
  bool is_own = false;  // of the sensor: no compression or filter took it away, and it widens histograms
};

// Adds the matches of one channel, linear at the curve g and at what the channels share, to its squares.
// black_level: codes. Returns the misfit: -2 ln of the likelihood.
double add_match_evidence(const HistogramMatches::OfChannel& channel, float black_level,
                          const MatchNoise& noise, const Eigen::VectorXd& g,
                          const shared_unknowns::Values& shared, CurveSquares& squares);

// The same of what is white in the longer exposure, where the curve breaks that: of the codes of the shorter
// one from which on it is, x is E1/E2 of white at least. It tells of the curve alone: broken under a curve
// that is known, a bound is of what moved.
double add_white_bounds(const HistogramMatches::OfChannel& channel, float black_level,
                        const MatchNoise& noise, const Eigen::VectorXd& g,
                        const shared_unknowns::Values& shared, CurveSquares& squares);

// The same of the darkest codes: of those of the shorter exposure below which hardly anything is, x is at
// most E1/E2 of the longer one's darkest. What breaks that by more than curves do is black.
double add_dark_bounds(const HistogramMatches::OfChannel& channel, float black_level, const MatchNoise& noise,
                       const Eigen::VectorXd& g, const shared_unknowns::Values& shared,
                       CurveSquares& squares);

}  // namespace hdrcam
