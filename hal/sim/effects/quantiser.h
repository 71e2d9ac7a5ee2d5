// Saturation and quantisation, which every sensor has: value v, 1 = saturated, becomes the whole number
// nearest to black + v (2^bits - 1 - black), within 0 .. 2^bits - 1. Value type, reentrant.
#pragma once

#include <algorithm>
#include <cstdint>

namespace hdrcam {

class Quantiser {
 public:
  // black_level: in codes
  Quantiser(int bits, float black_level)
      : largest_(static_cast<float>((1 << bits) - 1)), black_(black_level), span_(largest_ - black_level) {}

  std::uint16_t code(float value) const {
    return static_cast<std::uint16_t>(std::clamp(black_ + value * span_, 0.f, largest_) + 0.5f);
  }

 private:
  float largest_, black_, span_;
};

}  // namespace hdrcam
