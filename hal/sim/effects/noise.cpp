#include "hal/sim/effects/noise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/sim/counter_random.h"

namespace hdrcam {
namespace {

// From here on a Gaussian suffices: the skewness of the Poisson distribution is below 0.23.
constexpr float kGaussianFrom_e = 20;
constexpr std::uint64_t kShotStream = 0x73686f74, kReadStream = 0x72656164;

constexpr int kMostCounts = 100;  // of a small mean: more have a probability below 1e-30
constexpr auto kInverse = [] {
  std::array<float, kMostCounts + 1> inverse{};
  for (std::size_t n = 1; n < inverse.size(); ++n) inverse[n] = 1 / static_cast<float>(n);
  return inverse;
}();

// A Poisson number around `mean` from uniform u in [0, 1), by inversion; meant for small means.
float poisson(float mean, float u) {
  float probability = std::exp(-mean), sum = probability;
  std::size_t count = 0;
  while (u >= sum && count < kMostCounts) {
    probability *= mean * kInverse[++count];
    sum += probability;
  }
  return static_cast<float>(count);
}

}  // namespace

void Noise::apply(std::span<float> electrons, float full_well_e, std::uint64_t sequence,
                  std::uint64_t first_pixel) const {
  const CounterRandom shot(seed_, kShotStream, sequence), read(seed_, kReadStream, sequence);
  const auto drawn = [&](float mean, std::uint64_t pixel, float normal) {
    const float count =
        mean < kGaussianFrom_e ? poisson(mean, shot.uniform(pixel)) : mean + std::sqrt(mean) * normal;
    return std::clamp(count, 0.f, full_well_e);
  };
  // Normal numbers come in pairs: one pair for the shot noise of two neighbours, one for their reading. A
  // count of a small mean takes its pixel's own bits; a bright pixel that follows it takes those of its own.
  for (std::size_t i = 0; i < electrons.size(); i += 2) {
    const std::uint64_t pixel = first_pixel + i;
    const bool has_neighbour = i + 1 < electrons.size();
    float& a = electrons[i];
    float& b = electrons[has_neighbour ? i + 1 : i];
    const float mean_a = a, mean_b = b;
    const auto shots = std::max(mean_a, mean_b) < kGaussianFrom_e
                           ? CounterRandom::Pair{}
                           : shot.normals(mean_a < kGaussianFrom_e ? pixel + 1 : pixel);
    const auto reads = read.normals(pixel);
    if (has_neighbour) b = drawn(mean_b, pixel + 1, shots.b) + settings_.read_noise_e * reads.b;
    a = drawn(mean_a, pixel, shots.a) + settings_.read_noise_e * reads.a;
  }
}

}  // namespace hdrcam
