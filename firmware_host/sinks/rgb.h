// A colour of pictures for people: 8-bit sRGB. Value type.
#pragma once

#include <cstdint>

namespace hdrcam {

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;

  friend bool operator==(const Rgb&, const Rgb&) = default;
};

}  // namespace hdrcam
