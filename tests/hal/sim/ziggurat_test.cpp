// The normal numbers against the error function, the rare ones of the tail included.
#include "hal/sim/ziggurat.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("normal numbers lie beyond each limit as often as the error function says") {
  constexpr int kCount = 4'000'000;
  constexpr double kLimits[] = {0.1, 0.5, 1, 1.5, 2, 2.5, 3, 3.4, 3.5, 4};  // the tail begins at 3.44
  std::mt19937_64 bits(5);
  int beyond[std::size(kLimits)] = {}, negative = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x =
        static_cast<double>(kZiggurat.normal(static_cast<std::uint32_t>(bits()), [&] { return bits(); }));
    negative += x < 0;
    for (std::size_t k = 0; k < std::size(kLimits); ++k) beyond[k] += std::abs(x) > kLimits[k];
  }
  CHECK(negative == Approx(kCount / 2).margin(5 * std::sqrt(kCount / 4)));
  for (std::size_t k = 0; k < std::size(kLimits); ++k) {
    const double expected = std::erfc(kLimits[k] / std::sqrt(2)) * kCount;
    INFO("beyond " << kLimits[k]);
    CHECK(beyond[k] == Approx(expected).margin(5 * std::sqrt(expected)));
  }
}
