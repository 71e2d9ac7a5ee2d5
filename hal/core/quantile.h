// The value of some values below which a share of them lies. Reentrant.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <functional>
#include <span>

namespace hdrcam {

// Of n values the one of rank share * (n - 1), rounded down (render/scores/order_statistics.h interpolates
// between two, as numpy does). Reorders them; T{} for none. share: 0..1; the rank is computed in its type.
template <class T, std::floating_point Share, class Less = std::less<>>
T quantile(std::span<T> values, Share share, Less less = {}) {
  if (values.empty()) return T{};
  const auto rank = static_cast<std::size_t>(share * static_cast<Share>(values.size() - 1));
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), nth, values.end(), less);
  return *nth;
}

}  // namespace hdrcam
