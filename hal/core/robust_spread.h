// Centre and variance of samples that include outliers: moved or clipped pixels. Reentrant.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace hdrcam {

struct Spread {
  double centre = 0, variance = 0;
};

// Variance of the middle four fifths of the samples, scaled to the variance of a whole normal distribution.
// Reorders the samples; at least ten are needed.
inline Spread robust_spread(std::vector<float>& samples) {
  constexpr double kTail = 0.1;                 // left out on either side
  constexpr double kVarianceOfMiddle = 0.4377;  // of the middle of a normal distribution
  const auto tail = static_cast<std::ptrdiff_t>(kTail * static_cast<double>(samples.size()));
  const auto first = samples.begin() + tail, last = samples.end() - tail;
  std::nth_element(samples.begin(), first, samples.end());
  std::nth_element(first, last - 1, samples.end());
  const auto used = static_cast<double>(last - first);
  Spread spread;
  for (auto s = first; s != last; ++s) spread.centre += static_cast<double>(*s) / used;
  for (auto s = first; s != last; ++s) {
    const double off = static_cast<double>(*s) - spread.centre;
    spread.variance += off * off / used / kVarianceOfMiddle;
  }
  return spread;
}

}  // namespace hdrcam
