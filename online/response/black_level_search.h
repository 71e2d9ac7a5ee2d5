// The black level of a channel, where the camera does not state it: the one of some candidates under which
// its matches agree best with each other and with real cameras. A pedestal is the exception: it must explain
// the matches better by a penalty, and by two where it is above the darkest pixels, which compression may
// have put below black. The prior counts half below these, because it takes a dark scene under an unusual
// curve for a pedestal under a usual one, and does not argue for a level above them. A camera's channels are
// alike: where both others have a pedestal, it is its absence that must explain the matches better.
// Reentrant.
#pragma once

#include <functional>

namespace hdrcam {

// Of the curve that fits best: -2 ln of likelihood and prior.
struct CurveMisfit {
  double of_matches = 0, of_prior = 0;
};

// darkest, most: codes, HistogramMatches::darkest and most_black. misfit_at: of a level in codes.
// of_others: codes, the level that both other channels have in the mean; 0: not both have one. Returns codes.
float find_black_level(float darkest, float most, const std::function<CurveMisfit(float)>& misfit_at,
                       float of_others = 0);

}  // namespace hdrcam
