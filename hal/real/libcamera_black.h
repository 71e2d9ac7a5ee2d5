// The black level of a frame's raw codes as libcamera's metadata states it (SensorBlackLevels): of R, Gr, Gb
// and B, as if pixels had 16 bits, whatever the format has. One for all colours, as of a raw still.
// Reentrant.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/core/black_level.h"

namespace hdrcam {

// bits: of the raw codes. None where no code is as high, or as low.
inline std::optional<BlackLevel> black_level_of(std::span<const std::int32_t, 4> r_gr_gb_b, int bits) {
  constexpr int kBits = 16;
  double mean = 0;
  for (const std::int32_t level : r_gr_gb_b) mean += level / 4.0;
  const double code = std::ldexp(mean, bits - kBits);  // 64 of 10 bits is 4096
  if (!(code >= 0 && code < std::ldexp(1, bits) - 1)) return std::nullopt;
  return BlackLevel::of_code(code, bits);
}

}  // namespace hdrcam
