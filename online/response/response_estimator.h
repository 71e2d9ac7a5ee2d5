// Response from the first cycles of an alternating-exposure stream, nothing else known. Neighbouring frames see about
// the same scene, so their histograms match: the q-th quantile of one, at exposure E1, is the q-th of the other at E2.
// Each pair of codes (z1, z2) says g(z1) - g(z2) = ln E1/E2 with g = ln x. A robust MAP fit of g over 255 codes per
// channel, under a prior from real cameras (dorf_prior.inc), answers within two or three frames; no alignment, no flow
// (flow-matched samples made it worse: docs/decisions.md). Thread-bound.
#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "capture/exposed_frame.h"
#include "capture/noise_model.h"
#include "online/response/response.h"

namespace hdrcam {

class ResponseEstimator {
 public:
  static constexpr int kQuantiles = 400;  // per pair and channel

  // Adds what two frames of different exposure say about the response. Frames of (nearly) the same exposure, of
  // unproved exposure, or whose pictures cannot be of the same scene (a cut) are left out; returns whether it counted.
  bool add_pair(const ExposedFrame& a, const ExposedFrame& b);

  // Pairs that counted so far. Zero: solve() answers the mean of real cameras.
  int pairs() const { return pairs_; }

  // MAP estimate, about 10 ms. `noise` says how far codes may be off; `start` (may be null) saves iterations.
  Response solve(const NoiseModel& noise, const Response* start) const;

 private:
  struct Match {
    float z1, z2;  // codes of the shorter and of the longer exposure, 1..255
  };
  struct Matches {
    double log_ratio = 0;  // ln E1/E2 < 0
    std::vector<Match> codes;
  };

  int pairs_ = 0;
  std::array<std::map<std::pair<int, int>, Matches>, 3> matches_;  // by exposures in 1/64 stop
};

// The mean of real camera responses: what is assumed before anything is known.
Response prior_mean_response();

}  // namespace hdrcam
