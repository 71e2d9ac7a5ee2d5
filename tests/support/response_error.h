// How far one response is from another.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "online/response/response.h"

namespace hdrcam::test {

// rms difference of log2 x over codes 12..245 after removing one gain per channel, stops
inline double response_error(const Response& a, const Response& b) {
  constexpr std::size_t kFirst = 12, kLast = 245;
  constexpr double kCompared = kLast - kFirst + 1;
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    double mean = 0, square = 0;
    for (std::size_t z = kFirst; z <= kLast; ++z) {
      const double d = std::log2(a.inverse(c)[z]) - std::log2(b.inverse(c)[z]);
      mean += d, square += d * d;
    }
    sum += square / kCompared - (mean / kCompared) * (mean / kCompared);
  }
  return std::sqrt(std::max(0.0, sum / 3));
}

}  // namespace hdrcam::test
