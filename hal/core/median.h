// The median of some values. Reentrant.
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

}  // namespace hdrcam
