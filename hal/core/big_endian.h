// A whole number of up to eight bytes, the highest first, as MP4, ICC profiles and Matroska have theirs.
// Reentrant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace hdrcam {

inline std::uint64_t big_endian(std::span<const std::byte> bytes) {
  std::uint64_t value = 0;
  for (const std::byte byte : bytes) value = value << 8 | std::to_integer<std::uint64_t>(byte);
  return value;
}

}  // namespace hdrcam
