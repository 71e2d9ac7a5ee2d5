// Random numbers that are a function of (seed, stream, counter) and of nothing else: any pixel of any frame
// can be drawn by any thread in any order and is always the same. SplitMix64 (Steele, Lea and Flood, OOPSLA
// 2014) on a counter. Value type, reentrant.
#pragma once

#include <cstdint>

#include "hal/sim/ziggurat.h"

namespace hdrcam {

class CounterRandom {
 public:
  // One sequence of numbers for each (seed, stream, part): part is, for instance, the frame.
  CounterRandom(std::uint64_t seed, std::uint64_t stream, std::uint64_t part = 0)
      : key_(mix(mix(mix(seed + kStep) + stream) + part)) {}

  std::uint64_t bits(std::uint64_t counter) const { return mix(key_ + counter * kStep); }
  // [0, 1), 24 bits, so that it is exact in a float
  float uniform(std::uint64_t counter) const { return static_cast<float>(bits(counter) >> 40) * 0x1p-24f; }
  float uniform(std::uint64_t counter, float begin, float end) const {
    return begin + (end - begin) * uniform(counter);
  }

  // Two independent standard normal numbers.
  struct Pair {
    float a, b;
  };
  Pair normals(std::uint64_t counter) const {
    const std::uint64_t word = bits(counter);
    return {normal(static_cast<std::uint32_t>(word), word),
            normal(static_cast<std::uint32_t>(word >> 32), ~word)};
  }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15u;
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  // From 32 random bits and, once in eighty times, from more that follow from `seed`.
  static float normal(std::uint32_t random, std::uint64_t seed) {
    return kZiggurat.normal(random, [&] { return seed = mix(seed + kStep); });
  }

  std::uint64_t key_;
};

}  // namespace hdrcam
