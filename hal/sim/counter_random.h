// Random numbers that are a function of (seed, stream, counter) and of nothing else: any pixel of any frame
// can be drawn by any thread in any order and is always the same. SplitMix64 (Steele, Lea and Flood, OOPSLA
// 2014) on a counter. Value type, reentrant.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

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

  // Two independent standard normal numbers (Box and Muller 1958); |n| <= 6.7.
  struct Pair {
    float a, b;
  };
  Pair normals(std::uint64_t counter) const {
    const std::uint64_t word = bits(counter);
    const float u = (static_cast<float>(word >> 40) + 0.5f) * 0x1p-24f;
    const float turn = static_cast<float>(word & 0xffffff) * 0x1p-24f * 2 * std::numbers::pi_v<float>;
    const float radius = std::sqrt(-2 * std::log(u));
    return {radius * std::cos(turn), radius * std::sin(turn)};
  }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15u;
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  std::uint64_t key_;
};

}  // namespace hdrcam
