// How the pixels of each format of a camera lie in memory, and what their codes are: one table for packing
// (pixel_pack.h) and unpacking (capture/pixel_unpack.h). Plain values; reentrant.
#pragma once

#include <cstddef>

#include "hal/camera.h"
#include "hal/core/frame.h"

namespace hdrcam {

// Words: 16 bits, little endian. Mipi10, Mipi12: the high bytes of a group of pixels, then their low bits.
enum class Packing { Rgb, Bgr, Yuyv, Uyvy, Nv12, Jpeg, Bytes, Words, Mipi10, Mipi12 };

struct PixelPacking {
  Packing packing = Packing::Rgb;
  PixelLayout layout = PixelLayout::Rgb;  // of the codes; RGB for YUV and JPEG, which have none of their own
  int bits = 8;                           // of a code
};
PixelPacking packing_of(PixelFormat format);
// Whether its codes are the sensor's own, proportional to light above the black level: of a mosaic, or mono
// of more than 8 bits.
bool is_raw(PixelFormat format);
// Whether both are Bayer formats that differ in nothing but the order of their colours, which a sensor that
// is flipped changes.
bool alike_but_for_order(PixelFormat a, PixelFormat b);

// Bytes of a row of the first plane.
std::size_t row_bytes(Packing packing, int width);
// Bytes of a picture, all planes, with rows `stride` bytes apart; its last row is not padded.
std::size_t picture_bytes(Packing packing, int width, int height, std::size_t stride);
// Number of pixels that share bytes or samples: the width (and, for NV12, the height) is a multiple of it.
int sharing(Packing packing);

}  // namespace hdrcam
