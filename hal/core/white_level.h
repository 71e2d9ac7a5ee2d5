// The code that a camera delivers for all light that is too bright for it, by channel, in codes of 255
// whatever its bit depth. Value type, reentrant.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace hdrcam {

class WhiteLevel {
 public:
  constexpr WhiteLevel() = default;  // the largest code

  constexpr float operator[](std::size_t channel) const { return codes_[channel]; }
  void set(std::size_t channel, float codes_of_255) { codes_[channel] = codes_of_255; }
  bool is_largest_code() const { return *this == WhiteLevel(); }

  friend bool operator==(const WhiteLevel&, const WhiteLevel&) = default;

 private:
  std::array<float, 3> codes_{255, 255, 255};
};

}  // namespace hdrcam
