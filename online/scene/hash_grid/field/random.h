// PCG32 (O'Neill 2014, XSH-RR): the only random numbers in the fit. The seed fixes the sequence on every
// machine and compiler, unlike the distributions of <random>. Value type, thread-compatible.
#pragma once

#include <cstdint>

namespace hdrcam {

class Pcg32 {
 public:
  explicit Pcg32(std::uint64_t seed, std::uint64_t stream = 0) : increment_((stream << 1) | 1) {
    next();
    state_ += seed;
    next();
  }

  std::uint32_t next() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005ULL + increment_;
    const auto mixed = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
    const auto turn = static_cast<std::uint32_t>(old >> 59);
    return (mixed >> turn) | (mixed << ((32 - turn) & 31));
  }
  // uniform in [0, 1), 24 bits
  float uniform() { return static_cast<float>(next() >> 8) * 0x1p-24f; }
  float uniform(float low, float high) { return low + (high - low) * uniform(); }
  // uniform in 0 .. count - 1; the bias of the multiplication is below count / 2^32
  int below(int count) {
    return static_cast<int>((static_cast<std::uint64_t>(next()) * static_cast<std::uint64_t>(count)) >> 32);
  }

 private:
  std::uint64_t state_ = 0, increment_;
};

}  // namespace hdrcam
