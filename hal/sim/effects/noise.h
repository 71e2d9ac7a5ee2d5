// Shot and read noise: the electrons of a pixel are Poisson distributed around their mean and are read with a
// Gaussian error. Random numbers come from a counter, so a pixel's noise does not depend on the thread that
// computes it. Value type, reentrant.
#pragma once

#include <cstdint>
#include <span>

namespace hdrcam {

struct NoiseSettings {
  float read_noise_e = 8;  // electrons rms
};

class Noise {
 public:
  Noise(NoiseSettings settings, std::uint64_t seed) : settings_(settings), seed_(seed) {}

  // electrons: expected on input, drawn and clipped at the full well, then read, on output; the pixels are
  // those from `first_pixel` of frame `sequence`.
  void apply(std::span<float> electrons, float full_well_e, std::uint64_t sequence,
             std::uint64_t first_pixel) const;

 private:
  NoiseSettings settings_;
  std::uint64_t seed_;
};

}  // namespace hdrcam
