#include "hal/core/robust_spread.h"

#include <random>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

std::vector<float> normal_samples(std::size_t count, float mean, float sigma) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal(mean, sigma);
  std::vector<float> samples(count);
  for (float& sample : samples) sample = normal(random);
  return samples;
}

}  // namespace

TEST_CASE("a robust spread is that of the middle four fifths of the samples, in any order") {
  std::vector<float> samples{7, -1000, 3, 1, 8, 6, 2, 1000, 5, 4};  // 1 to 8, and two outliers
  const Spread spread = robust_spread(samples);
  CHECK(spread.centre == Approx(4.5));
  CHECK(spread.variance == Approx(5.25 / 0.4377));
}

TEST_CASE("a robust spread of normal samples is their variance, which outliers hardly change") {
  std::vector<float> samples = normal_samples(20'000, 5, 2);
  const Spread clean = robust_spread(samples);
  CHECK(clean.centre == Approx(5).margin(0.05));
  CHECK(clean.variance == Approx(4).epsilon(0.05));

  samples = normal_samples(20'000, 5, 2);
  for (std::size_t i = 0; i < samples.size(); i += 20) samples[i] = 1000;  // one in twenty
  const Spread spoilt = robust_spread(samples);
  CHECK(spoilt.centre == Approx(5).margin(0.3));
  CHECK(spoilt.variance == Approx(4).epsilon(0.25));
}
