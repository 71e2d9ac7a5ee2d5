// Constants shared by the writer and the reader of a recording (docs/recording.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hdrcam::matroska {

// The first bytes of every Matroska file: the identifier of an EBML header.
inline constexpr std::array kFileHead{std::byte{0x1a}, std::byte{0x45}, std::byte{0xdf}, std::byte{0xa3}};
inline constexpr const char* kCameraTag = "HDRCAM_CAMERA";
inline constexpr int kPixelTrack = 0, kFactsTrack = 1;  // stream indices
inline constexpr std::uint64_t kBlockHead = 4;          // bytes of a block: track, time (2 bytes), flags

}  // namespace hdrcam::matroska
