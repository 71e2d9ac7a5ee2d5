// The code that a sensor delivers without light, by channel. One unit everywhere, from the sensor table to
// the fit: codes of 255, the scale of an exposed frame's codes whatever the sensor's bit depth. Value type,
// reentrant.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace hdrcam {

class BlackLevel {
 public:
  constexpr BlackLevel() = default;  // none
  // The same for all channels, in codes of 255.
  constexpr explicit BlackLevel(double codes_of_255) : codes_{codes_of_255, codes_of_255, codes_of_255} {}
  // A code of a sensor whose largest code is 2^bits - 1.
  static constexpr BlackLevel of_code(double code, int bits) {
    return BlackLevel(code * 255 / static_cast<double>((1 << bits) - 1));
  }

  float operator[](std::size_t channel) const { return static_cast<float>(codes_[channel]); }
  void set(std::size_t channel, float codes_of_255) { codes_[channel] = static_cast<double>(codes_of_255); }
  // The green channel's, in codes of so many bits, rounded to a millionth: files store it, and it reads back
  // the same.
  double code(int bits) const {
    return std::round(codes_[1] * static_cast<double>((1 << bits) - 1) / 255 * 1e6) / 1e6;
  }

  friend bool operator==(const BlackLevel&, const BlackLevel&) = default;

 private:
  std::array<double, 3> codes_{};  // of 255
};

}  // namespace hdrcam
