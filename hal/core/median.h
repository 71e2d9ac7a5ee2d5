// The median of some values, and the spread that it tells. Reentrant.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace hdrcam {

// Reorders them; 0 for none.
template <class T>
T median(std::span<T> values) {
  if (values.empty()) return T{};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
template <class T>
T median(std::vector<T>& values) {
  return median(std::span(values));
}

// Standard deviation of normal values over the median of their absolute deviations.
constexpr double kSigmaPerMad = 1.4826;

}  // namespace hdrcam
