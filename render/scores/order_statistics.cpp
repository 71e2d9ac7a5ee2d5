#include "render/scores/order_statistics.h"

#include <algorithm>
#include <cmath>

#include "hal/core/check.h"

namespace hdrcam {

double percentile(std::vector<float>& samples, double percent) {
  HDRCAM_CHECK(!samples.empty());
  HDRCAM_CHECK(percent >= 0 && percent <= 100);
  const double position = percent / 100 * static_cast<double>(samples.size() - 1);
  const double below = std::floor(position);
  const auto nth = samples.begin() + static_cast<std::ptrdiff_t>(below);
  std::nth_element(samples.begin(), nth, samples.end());
  const double low = static_cast<double>(*nth);
  if (position == below) return low;
  const double high = static_cast<double>(*std::min_element(nth + 1, samples.end()));
  return low + (high - low) * (position - below);
}

}  // namespace hdrcam
