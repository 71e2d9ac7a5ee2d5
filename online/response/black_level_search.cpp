#include "online/response/black_level_search.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace hdrcam {

float find_black_level(float darkest, float most, const std::function<CurveMisfit(float)>& misfit_at,
                       const OtherBlackLevels& others) {
  constexpr float kHighest = 24;  // codes: above, dark pixels are a bright scene
  constexpr double kPenalty = 10, kPriorShare = 0.5;
  constexpr float kUnlike = 4;  // codes, standard deviation between the channels of a camera
  darkest = std::min(darkest, kHighest), most = std::min(most, kHighest);
  const auto unlike = [&](float level) -> double {
    if (others.found == 0) return level > 0 ? kPenalty : 0;
    const float off = (level - others.mean) / kUnlike;
    if (level > 0) return off * off;
    return others.found == 1 ? 0 : kPenalty + off * off;
  };
  double usual = std::numeric_limits<double>::max();  // the prior's misfit at levels that are not above
  const auto misfit = [&](float level) {
    const CurveMisfit agreed = misfit_at(level);
    const bool above = level > darkest;
    if (!above) usual = std::min(usual, agreed.of_prior);
    return agreed.of_matches + kPriorShare * (above ? std::max(usual, agreed.of_prior) : agreed.of_prior) +
           unlike(level) + (above ? kPenalty : 0);
  };
  std::vector<float> levels{0};
  const float third = (most - darkest) / 3;
  for (const float level : {darkest / 2, darkest, darkest + third, most - third, most})
    if (level >= levels.back() + 1) levels.push_back(level);
  if (levels.size() == 1) return 0;
  std::vector<double> misfits;
  misfits.reserve(levels.size());
  for (const float level : levels) misfits.push_back(misfit(level));

  const auto least =
      static_cast<std::size_t>(std::min_element(misfits.begin(), misfits.end()) - misfits.begin());
  float best = levels[least];
  if (least == 0) return best;
  double smallest = misfits[least];
  for (const std::size_t beside : {least - 1, least + 1}) {
    if (beside == levels.size()) continue;
    const float between = (levels[least] + levels[beside]) / 2;
    if (const double m = misfit(between); m < smallest) smallest = m, best = between;
  }
  return best;
}

}  // namespace hdrcam
