// Smooth noise on a lattice, from which textures are built (Perlin's lattice with values instead of
// gradients). Results lie in [-1, 1]. Reentrant.
#pragma once

#include <cstdint>

#include "hal/sim/geometry.h"

namespace hdrcam {

// -1..1, one number for each lattice point
inline float lattice_value(int x, int y, int z, std::uint32_t seed) {
  std::uint32_t h = seed + static_cast<std::uint32_t>(x) * 0x9e3779b1u +
                    static_cast<std::uint32_t>(y) * 0x85ebca77u + static_cast<std::uint32_t>(z) * 0xc2b2ae3du;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return static_cast<float>((h ^ (h >> 15)) >> 8) * 0x1p-23f - 1;
}

// A noise field in space.
float value_noise(Vec3 p, std::uint32_t seed);
// In the plane, repeating after `period` lattice steps (a power of two).
float value_noise(float u, float v, int period, std::uint32_t seed);

// Octaves of noise, each of twice the frequency and 0.6 of the amplitude; about [-1, 1].
float fractal_noise(Vec3 p, int octaves, std::uint32_t seed);
float fractal_noise(float u, float v, int first_period, int octaves, std::uint32_t seed);  // (u, v) in tiles

}  // namespace hdrcam
