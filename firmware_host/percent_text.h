// A share in percent with one decimal: "37.5". 100.0 only where it is all, which 99.96 is not. Reentrant.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace hdrcam {

// share: 0..1.
inline std::string percent_text(double share) {
  constexpr double kMostOfSome = 99.9;
  return fmt::format("{:.1f}", share < 1 ? std::min(100 * share, kMostOfSome) : 100);
}

}  // namespace hdrcam
