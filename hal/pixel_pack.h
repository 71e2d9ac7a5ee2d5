// Codes -> the bytes of a buffer, for the simulated and the replayed camera, which have no driver. The
// inverse of the unpacking in capture/; lossy formats (YUV, MJPEG) are not offered.
// Reentrant.
#pragma once

#include <optional>

#include "hal/camera.h"
#include "hal/core/frame.h"

namespace hdrcam {

struct PackedFormat {
  PixelLayout layout = PixelLayout::Rgb;
  int bits = 8;      // of a code
  int multiple = 1;  // the width is a multiple of this
};

// nullopt for YUV and MJPEG.
std::optional<PackedFormat> packed_format(PixelFormat format);
// The format that holds such codes without loss, or nullopt (RGB above 8 bits).
std::optional<PixelFormat> format_for(PixelLayout layout, int bits);

// Bytes of a row of a packed format.
std::size_t packed_stride(PixelFormat format, int width);
// codes: [channels, rows, cols] of the format's layout and bits; bytes: rows * packed_stride.
void pack_codes(const Image<std::uint16_t>& codes, PixelFormat format, std::span<std::byte> bytes);

}  // namespace hdrcam
