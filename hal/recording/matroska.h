// What the writer, the reader and the search of a recording share of its container (docs/recording.md).
// Reentrant.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/core/big_endian.h"

namespace hdrcam::matroska {

// The first bytes of every Matroska file: the identifier of an EBML header.
inline constexpr std::array kFileHead{std::byte{0x1a}, std::byte{0x45}, std::byte{0xdf}, std::byte{0xa3}};
inline constexpr const char* kCameraTag = "HDRCAM_CAMERA";
inline constexpr int kPixelTrack = 0, kFactsTrack = 1;  // stream indices
inline constexpr std::uint64_t kBlockHead = 4;          // bytes of a block: track, time (2 bytes), flags

// How many bytes an identifier or a size has that begins with this one: its leading zeros say so.
inline std::size_t length_by(std::byte first) {
  return static_cast<std::size_t>(std::countl_zero(std::to_integer<std::uint8_t>(first))) + 1;
}

struct ElementSize {
  std::uint64_t bytes = 0;  // of the element's content
  std::size_t length = 0;   // of the size itself
};

// The size with which these bytes begin; nullopt where it goes on behind them, and where it is the one that
// stands for an unknown size.
inline std::optional<ElementSize> size_in(std::span<const std::byte> bytes) {
  if (bytes.empty()) return {};
  const std::size_t length = length_by(bytes.front());
  if (length > 8 || length > bytes.size()) return {};
  const std::uint64_t all_ones = (std::uint64_t{1} << (7 * length)) - 1;  // behind the length's marker
  const std::uint64_t size = big_endian(bytes.first(length)) & all_ones;
  if (size == all_ones) return {};
  return ElementSize{size, length};
}

}  // namespace hdrcam::matroska
