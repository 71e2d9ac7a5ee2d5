// The black level of a channel, where the camera does not state it: the one of some candidates under which
// its matches agree best with each other and with real cameras. A pedestal is the exception: it must explain
// the matches better by a penalty, and by two where it is above the darkest pixels, which compression may
// have put below black. The prior counts half below these, because it takes a dark scene under an unusual
// curve for a pedestal under a usual one, and does not argue for a level above them. A camera's channels are
// alike: where one of the others has a pedestal, neither having one nor having none costs anything, and where
// both have one, it is its absence that must explain the matches better. Reentrant.
#pragma once

#include <functional>

namespace hdrcam {

// Of the curve that fits best: -2 ln of likelihood and prior.
struct CurveMisfit {
  double of_matches = 0, of_prior = 0;
};

// Of the camera's other channels.
struct OtherBlackLevels {
  int found = 0;   // channels that have a black level
  float mean = 0;  // codes, of these
};

// darkest, most: codes, HistogramMatches::darkest and most_black. misfit_at: of a level in codes.
// Returns codes.
float find_black_level(float darkest, float most, const std::function<CurveMisfit(float)>& misfit_at,
                       const OtherBlackLevels& others = {});

}  // namespace hdrcam
