#include "hal/sim/value_noise.h"

#include <cmath>

namespace hdrcam {
namespace {

constexpr float kOctaveGain = 0.6f;

float smooth(float t) { return t * t * (3 - 2 * t); }
float mixed(float a, float b, float t) { return a + (b - a) * t; }

// Lattice cell and smoothed position within it.
struct Cell {
  explicit Cell(float x) : index(static_cast<int>(std::floor(x))), t(smooth(x - std::floor(x))) {}
  int index;
  float t;
};

}  // namespace

float value_noise(Vec3 p, std::uint32_t seed) {
  const Cell x(p.x), y(p.y), z(p.z);
  const auto line = [&](int j, int k) {
    return mixed(lattice_value(x.index, j, k, seed), lattice_value(x.index + 1, j, k, seed), x.t);
  };
  const auto plane = [&](int k) { return mixed(line(y.index, k), line(y.index + 1, k), y.t); };
  return mixed(plane(z.index), plane(z.index + 1), z.t);
}

float value_noise(float u, float v, int period, std::uint32_t seed) {
  const Cell x(u), y(v);
  const int mask = period - 1;
  const auto at = [&](int i, int j) { return lattice_value(i & mask, j & mask, 0, seed); };
  return mixed(mixed(at(x.index, y.index), at(x.index + 1, y.index), x.t),
               mixed(at(x.index, y.index + 1), at(x.index + 1, y.index + 1), x.t), y.t);
}

float fractal_noise(Vec3 p, int octaves, std::uint32_t seed) {
  float sum = 0, gain = 1, total = 0;
  for (int i = 0; i < octaves; ++i, gain *= kOctaveGain, p = p * 2)
    sum += gain * value_noise(p, seed + static_cast<std::uint32_t>(i)), total += gain;
  return sum / total * 1.6f;
}

float fractal_noise(float u, float v, int first_period, int octaves, std::uint32_t seed) {
  float sum = 0, gain = 1, total = 0;
  for (int i = 0, period = first_period; i < octaves; ++i, gain *= kOctaveGain, period *= 2) {
    const float frequency = static_cast<float>(period);
    sum += gain * value_noise(u * frequency, v * frequency, period, seed + static_cast<std::uint32_t>(i));
    total += gain;
  }
  return sum / total * 1.6f;
}

}  // namespace hdrcam
